"""How well a log will determine the parameters, from its noise-free simulation and the sensors' noise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import Rows
from pyident.estimation.least_squares import ROUNDING
from pyident.logs.log import Log
from pyident.refinement.instruments.noise_scatter import carries, noise_scatter
from pyident.regression.equations import Problem
from pyident.regression.machine.svd import svd
from pyident.regression.reduced import reduce
from pyident.regression.regressor import regressor, residual_of

_ABSENT = 1e-3  # entry of a scaled null direction below which a parameter is not in it
_DRAWS = 4  # of the noise


@dataclass(frozen=True)
class Prediction:
    """What identification will find, as far as the sensors' noise limits it.

    std               parameter -> standard deviation; inf: known only in combinations, or not at all
    values            parameter -> the value that the motion was designed with
    singular_values   of the weighted regressor with columns of unit length, largest first
    """

    std: Mapping[str, float]
    values: Mapping[str, float]
    rank: int
    singular_values: np.ndarray

    @property
    def condition(self) -> float:
        """Largest over smallest singular value of those that count."""
        return float(self.singular_values[0] / self.singular_values[self.rank - 1])


def predicted(robot: Robot, log: Log, noise: Mapping[str, float]) -> Prediction:
    """Of least squares with instruments, which noise does not bias.

    log     noise-free, of this robot;  noise: channel -> standard deviation
    A direction counts when noise leaves its coefficient a standard deviation below the largest one.
    """
    problem = Problem(robot, (part := condition(log, robot),))
    reduced = reduce(problem.blocks(), problem.rows, problem.columns)
    weights = 1 / row_noise(robot, log, part, noise)
    A, y = reduced.stacked(weights)
    scale = np.linalg.norm(A, axis=0)
    absent = scale <= ROUNDING * scale.max()
    scale[absent] = 1.0
    U, s, Vt = svd(A / scale)
    Vt[: np.count_nonzero(s > ROUNDING * s[0]), absent] = 0.0
    rank = _rank(s, U.T @ y)
    seen, null = Vt[:rank].T, Vt[rank:].T
    turn = seen / s[:rank] / scale[:, None]
    meat = np.eye(rank)
    p = np.array([robot.parameters[name] for name in reduced.columns])
    if carries(robot):
        Phi = regressor(robot, part.motion).matrix
        rows = Rows(Phi, Phi, part.target, part.use)
        meat = noise_scatter(robot, part, rows, p, weights, turn, noise, log.period)
    open_ = np.linalg.norm(null, axis=1) > _ABSENT
    std = np.where(open_, np.inf, np.sqrt(np.maximum(np.einsum("ir,rs,is->i", turn, meat, turn), 0)))
    names = reduced.columns
    return Prediction(
        dict(zip(names, std.tolist(), strict=True)), dict(zip(names, p.tolist(), strict=True)), rank, s
    )


def row_noise(robot: Robot, log: Log, part: Conditioned, noise: Mapping[str, float]) -> np.ndarray:
    """(n,) rms that the sensors' noise leaves on a sample of each equation."""
    p = np.array([robot.parameters[name] for name in robot.linear_parameters])
    rng = np.random.default_rng(0)
    clean = residual_of(robot, part, p)
    squares = np.zeros(part.target.shape[1])
    for _ in range(_DRAWS):
        frame = log.frame.copy()
        for name, sigma in noise.items():
            frame[name] = frame[name] + sigma * rng.standard_normal(len(frame))
        noisy = condition(Log(frame, log.source), robot)
        left = residual_of(robot, replace(noisy, use=part.use), p) - clean
        squares += (left**2).sum(axis=0) / np.maximum(part.use.sum(axis=0), 1)
    rms = np.sqrt(squares / _DRAWS)
    return np.maximum(rms, 1e-9 * rms.max())


def _rank(s: np.ndarray, coefficients: np.ndarray) -> int:
    rank = int((s > ROUNDING * s[0]).sum())
    size = np.abs(coefficients[:rank] / s[:rank])
    while rank > 1 and 1 / s[rank - 1] > size[: rank - 1].max():
        rank -= 1
    return rank
