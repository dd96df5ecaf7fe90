"""How well a log will determine the parameters, from its simulation with and without the sensors' noise."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import Rows
from pyident.estimation.least_squares import ROUNDING
from pyident.excitation.rehearsals.rehearsal import Rehearsal
from pyident.logs.log import Log, LogError
from pyident.refinement.identifications import DEFAULT, IDENTIFICATIONS
from pyident.refinement.instruments.noise_scatter import noise_scatter
from pyident.regression.equations import Problem
from pyident.regression.machine.svd import svd
from pyident.regression.reduced import reduce
from pyident.regression.regressor import regressor, residual_of
from pyident.simulation.simulator import OpenPool

_ABSENT = 1e-3  # entry of a scaled null direction below which a parameter is not in it
_DRAWS = 4  # of the noise
_SEED = 201  # of the noise in the log that is identified: none of the search's


@dataclass(frozen=True)
class Prediction:
    """What identification will find, as far as the sensors' noise limits it.

    std               parameter -> standard deviation that `identify` gives a log with noise; inf: none
    std_regression    parameter -> the same of a plain regression; inf: only in combinations, or not at all
    values            parameter -> the value that the motion was designed with
    rank, singular_values   of the weighted regressor with columns of unit length, largest first
    notes             why there are no values by `identify`, a sentence
    """

    std: Mapping[str, float]
    std_regression: Mapping[str, float]
    values: Mapping[str, float]
    rank: int
    singular_values: np.ndarray
    notes: tuple[str, ...] = ()

    @property
    def condition(self) -> float:
        """Largest over smallest singular value of those that count."""
        return float(self.singular_values[0] / self.singular_values[self.rank - 1])


def predicted(
    own: Rehearsal, plan: Experiment, noise: Mapping[str, float], open_pool: OpenPool
) -> Prediction:
    """What the default estimator says of a log with noise, and of least squares by a log without.

    noise   channel -> standard deviation
    An interrupt leaves those of least squares. Raises SimulationError.
    """
    found = _by_regression(own.robot, own.log(plan), noise)
    try:
        fit = IDENTIFICATIONS[DEFAULT](own.robot, own.noisy(plan, noise, [_SEED]), open_pool)
    except (LogError, SimulationError) as error:
        return replace(found, notes=(f"`identify` would give no values of a log of this motion: {error}",))
    except KeyboardInterrupt:
        return replace(found, notes=("interrupted before a log of this motion was identified",))
    alone = {
        name: float(std)
        for name, std in zip(fit.reduced.columns, fit.solution.std, strict=True)
        if fit.support[name] == "alone" and np.isfinite(std) and std > 0
    }
    if not alone:
        return replace(
            found, notes=tuple(f"`identify`, of a log of this motion: {said}" for said in fit.notes)
        )
    return replace(found, std={name: alone.get(name, np.inf) for name in found.std})


def _by_regression(robot: Robot, log: Log, noise: Mapping[str, float]) -> Prediction:
    """Of least squares with instruments, which noise does not bias.

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
    if not robot.settings.processing.filters:
        Phi = regressor(robot, part.motion).matrix
        rows = Rows(Phi, Phi, part.target, part.use)
        meat = noise_scatter(robot, part, rows, p, weights, turn, noise, log.period)
    open_ = np.linalg.norm(null, axis=1) > _ABSENT
    std = np.where(open_, np.inf, np.sqrt(np.maximum(np.einsum("ir,rs,is->i", turn, meat, turn), 0)))
    names = reduced.columns
    by_regression, values = (dict(zip(names, found.tolist(), strict=True)) for found in (std, p))
    return Prediction(dict.fromkeys(names, np.inf), by_regression, values, rank, s)


def row_noise(robot: Robot, log: Log, part: Conditioned, noise: Mapping[str, float]) -> np.ndarray:
    """(n,) rms that the sensors' noise leaves on a sample of each equation."""
    p = np.array([robot.parameters[name] for name in robot.linear_parameters])
    rng = np.random.default_rng(0)
    clean = residual_of(robot, part, p)
    squares = np.zeros(part.target.shape[1])
    for _ in range(_DRAWS):
        noisy = condition(log.noisier(noise, rng), robot)
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
