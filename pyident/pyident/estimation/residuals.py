"""What an identified robot leaves of the motor torques: errors, spectra, and whether the rest is slow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.identify import relative_error
from pyident.estimation.least_squares import Solution
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.regression.regressor import residual_of

_SEGMENT = 1024  # samples of one periodogram
SLOW = 0.1  # of the log's band: what lies below is slow


@dataclass(frozen=True)
class JointResidual:
    """The motor torque of one joint, and what the robot leaves of it.

    frequency         (F,) Hz
    torque, residual  (F,) densities of amplitude [N m/√Hz, N/√Hz]
    slow              share of the residual's power below a tenth of the band; of white noise it is a tenth
    """

    name: str
    frequency: np.ndarray
    torque: np.ndarray
    residual: np.ndarray
    slow: float


def joint_residuals(robot: Robot, logs: Sequence[Log]) -> list[JointResidual]:
    """A residual per joint, its power averaged over logs of one rate. Raises LogError."""
    from scipy.signal import welch

    p = np.array(list(robot.linear_parameters.values()))
    n, powers, frequency = len(robot.joints), [], np.zeros(0)
    length = min(_SEGMENT, *(len(log.frame) for log in logs))
    for log in logs:
        part = condition(log, robot)
        both = np.stack([part.all_used(part.target)[:, :n], residual_of(robot, part, p)[:, :n]])
        frequency, power = welch(both, 1 / log.period, nperseg=min(length, both.shape[1]), axis=1)
        powers.append(power)
    torque, residual = np.mean(powers, axis=0)
    low = frequency <= SLOW * frequency[-1]
    total = np.maximum(residual.sum(axis=0), 1e-300)
    slow = residual[low].sum(axis=0) / total
    return [
        JointResidual(
            joint_name(k + 1), frequency, np.sqrt(torque[:, k]), np.sqrt(residual[:, k]), float(slow[k])
        )
        for k in range(n)
    ]


def torque_error(
    robot: Robot, log: Log, taken: Callable[[Robot, Log], Conditioned] | None = None
) -> dict[str, float]:
    """100 |tau - Φ p| / |tau| of a log under the robot's own parameters, per joint and over all [%].

    taken   how equations are made of the log; none: as the robot's [processing] says
    Raises LogError.
    """
    part = taken(robot, log) if taken else condition(log, robot)
    p = np.array(list(robot.linear_parameters.values()))
    return relative_error(Problem(robot, (part,)).reduced(), p, len(robot.joints))


def correlations(solution: Solution, names: Sequence[str], count: int = 8) -> list[tuple[float, str, str]]:
    """The most correlated pairs of parameters that are determined alone: (correlation, one, other)."""
    std = solution.std
    told = np.flatnonzero(np.isfinite(std) & (std > 0) & ~solution.open).tolist()
    matrix = solution.covariance[np.ix_(told, told)] / np.outer(std[told], std[told])
    pairs = np.column_stack(np.triu_indices(len(told), 1))
    most = np.argsort(-np.abs(matrix[pairs[:, 0], pairs[:, 1]]))[:count]
    named = [names[i] for i in told]
    return [(float(matrix[i, j]), named[i], named[j]) for i, j in pairs[most].tolist()]
