"""Output error on positions alone: what a servo's log can say of a robot whose torque nobody measured.

The robot is simulated as an FMU under the recorded commands, its servos inside; the free parameters are those
whose positions come nearest to the measured ones (robust least squares, as sticking makes single errors
large). Intervals are a jackknife over the logs, linearised at the optimum: what a log leaves out moves.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
import pandas as pd

from flexmodels.coordinate import joint_number, motor_of
from flexmodels.experiment import Experiment
from flexmodels.joint import parameter_name
from flexmodels.named_values import settable, with_settings
from flexmodels.robot import Robot
from pyident.estimation.identify import finite
from pyident.logs.encoders import noise_of
from pyident.logs.log import Log, LogError
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.references import experiment_of
from pyident.simulation.simulator import Simulate

# Such as `FmuRuns`: a frame per set of parameters.

_ROUGH = 0.03  # [rad or m] error from which on it counts by its size and no longer by its square
_STEP = 1e-3  # finite difference, of a parameter's scale
_ROUNDS = 30
_FEWEST = 3  # logs of a jackknife
_MEAN_OF_NORMAL = float(np.sqrt(2 / np.pi))  # absolute value, per standard deviation
_AT_ONCE = 6.0  # times as far as in the samples before and after: no motion goes so
_USUAL = 0.8  # of what is still to be done is so after a round


@dataclass(frozen=True)
class ServoLog:
    """A recorded motion and what was set otherwise while it was recorded (`servo.kp` -> 400)."""

    log: Log
    settings: Mapping[str, float]


@dataclass(frozen=True)
class ClosedLoopFit:
    """What follows the logs best.

    robot   has the values;  error: mean absolute one of each log [rad or m]
    std     1.96 of them are half a 95 % interval; infinite of a value on its bound; None with fewer than
            three logs
    unmodelled   of each log the same error of a joint that stays at its command, or in its middle, whichever
            is nearer: a simulation that comes no nearer tells nothing
    noise        of each log the same error that the encoders make, and the unknown instants at which
                 commands jump
    at_bound     names of values at the least that they may have;  unseen: of those that moved nothing
    """

    robot: Robot
    values: Mapping[str, float]
    std: Mapping[str, float] | None
    error: tuple[float, ...]
    unmodelled: tuple[float, ...] = ()
    noise: tuple[float, ...] = ()
    at_bound: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ()

    def json(self) -> dict[str, Any]:
        parameters = {
            name: {"value": value, "std": finite(self.std[name]) if self.std else None}
            for name, value in self.values.items()
        }
        return {
            "parameters": parameters,
            "mean_absolute_error": list(self.error),
            "unmodelled_error": list(self.unmodelled),
            "noise_error": list(self.noise),
            "at_bound": list(self.at_bound),
            "unseen": list(self.unseen),
        }


def fit_closed_loop(
    robot: Robot,
    recordings: Sequence[ServoLog],
    free: Sequence[str],
    simulate: Simulate,
    rounds: int = _ROUNDS,
    groups: Sequence[Sequence[str]] | None = None,
    progress: Callable[[float], None] | None = None,
) -> ClosedLoopFit:
    """Change the `free` parameters until the simulation follows the logs.

    robot      its values are the start;  simulate   of this robot's FMU
    groups     names of `free` that are moved at once because each turns its own joint alone (stiff servos):
               a run per group instead of one per parameter. None: every parameter by itself.
    progress   called with the share of the rounds that are behind
    Raises LogError, SimulationError.
    """
    from scipy.optimize import least_squares

    runs = [_Run.of(robot, recording) for recording in recordings]
    at = settable(robot)
    start = np.array([at[name] for name in free])
    lower = np.array([_lower(robot, name) for name in free])
    scale = np.maximum(np.abs(start), np.array([_least(robot, name) for name in free]))
    slopes = _Slopes(tuple(free), tuple(map(tuple, groups or [[name] for name in free])), _STEP * scale)

    def residual(p: np.ndarray) -> np.ndarray:
        values = dict(zip(free, p, strict=True))
        return np.concatenate([run.errors(simulate, [values])[0].ravel() for run in runs])

    done = count()

    def jacobian(p: np.ndarray) -> np.ndarray:
        if progress:
            progress(1 - _USUAL ** next(done))
        return np.concatenate([slopes.of(run, simulate, p) for run in runs])

    begin = np.maximum(start, lower + 1e-9 * scale)
    best = least_squares(
        residual, begin, jac=jacobian,  # pyright: ignore[reportArgumentType]
        bounds=(lower, np.inf), x_scale=scale, loss="soft_l1", f_scale=_ROUGH,
        max_nfev=rounds, ftol=1e-5, xtol=1e-6,
    )  # fmt: skip
    values = dict(zip(free, (float(v) for v in best.x), strict=True))
    lengths = [run.measured.size for run in runs]
    parts = np.split(best.fun, np.cumsum(lengths)[:-1])
    inside = best.active_mask == 0
    few = len(runs) < _FEWEST
    std = None if few else _jackknife(np.asarray(best.jac), best.fun, lengths, scale, inside)
    return ClosedLoopFit(
        with_settings(robot, values),
        values,
        None if std is None else dict(zip(free, std.tolist(), strict=True)),
        tuple(float(np.abs(part).mean()) for part in parts),
        tuple(run.unmodelled for run in runs),
        tuple(max(one.encoders for one in runs) + run.jumps for run in runs),
        _named(free, best.x - lower < _STEP * scale),
        _named(free, np.linalg.norm(np.asarray(best.jac), axis=0) == 0),
    )


def _named(free: Sequence[str], which: np.ndarray) -> tuple[str, ...]:
    return tuple(name for name, taken in zip(free, which, strict=True) if taken)


def replay_errors(
    robot: Robot, recordings: Sequence[ServoLog], simulate: Simulate
) -> list[tuple[pd.DataFrame, np.ndarray]]:
    """Per log the simulation under its commands, and simulated − measured positions (N, joints)."""
    found = []
    for recording in recordings:
        run = _Run.of(robot, recording)
        frame = next(iter(simulate(run.plan, [{**settable(robot), **run.settings}])))
        found.append((frame, frame[list(run.channels)].to_numpy() - run.measured))
    return found


@dataclass(frozen=True)
class _Run:
    plan: Experiment
    measured: np.ndarray  # (N, joints)
    channels: tuple[str, ...]
    settings: Mapping[str, float]

    @staticmethod
    def of(robot: Robot, recording: ServoLog) -> "_Run":
        channels = tuple(motor_of(k) for k, _ in robot.numbered)
        missing = [name for name in channels if name not in recording.log.frame]
        if missing:
            raise LogError(f"{recording.log.source}: column {missing[0]} is missing, the measured position")
        plan = experiment_of(recording.log, len(robot.joints))
        settings = with_settings(robot, recording.settings)
        changed = {name: v for name, v in settable(settings).items() if v != settable(robot)[name]}
        return _Run(plan, recording.log.signals(channels), channels, changed)

    @property
    def unmodelled(self) -> float:
        nearest = np.minimum(
            np.abs(self.plan.reference - self.measured).mean(axis=0),
            np.abs(self.measured - np.median(self.measured, axis=0)).mean(axis=0),
        )
        return float(nearest.mean())

    @property
    def encoders(self) -> float:
        """The error that their noise makes; less where they mostly stand."""
        return float(np.mean([_MEAN_OF_NORMAL * noise_of(x) for x in self.measured.T]))

    @property
    def jumps(self) -> float:
        """What half a sample does where a command jumps between two of them."""
        moved = np.abs(np.diff(self.measured, axis=0)).mean(axis=0)
        return float(np.mean([_jumps(r) * m / 2 for r, m in zip(self.plan.reference.T, moved, strict=True)]))

    def errors(self, simulate: Simulate, sets: Sequence[Mapping[str, float]]) -> np.ndarray:
        """(sets, samples, joints), simulated − measured."""
        frames = simulate(self.plan, [{**self.settings, **p} for p in sets])
        return np.array([f[list(self.channels)].to_numpy() - self.measured for f in frames])


def _jumps(command: np.ndarray) -> float:
    """The share of a command's way (N,) that it goes from one sample to the next, between others at rest."""
    way = np.abs(np.diff(command))
    if len(way) < 5 or not way.any():
        return 0.0
    at_once = way[1:-3] + way[2:-2] + way[3:-1]  # what was resampled is smeared
    beside = np.maximum(way[:-4], way[4:])
    peak = (way[2:-2] >= way[1:-3]) & (way[2:-2] > way[3:-1]) & (at_once > _AT_ONCE * beside)
    return float(at_once[peak].sum() / way.sum())


@dataclass(frozen=True)
class _Slopes:
    """Forward differences of a run's positions, (samples x joints, parameters)."""

    free: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    steps: np.ndarray

    def of(self, run: _Run, simulate: Simulate, p: np.ndarray) -> np.ndarray:
        column = {name: i for i, name in enumerate(self.free)}
        sets = [dict(zip(self.free, p, strict=True))]
        for group in self.groups:
            sets.append(sets[0] | {name: p[column[name]] + self.steps[column[name]] for name in group})
        base, *moved = run.errors(simulate, sets)
        slopes = np.zeros((*base.shape, len(self.free)))
        for group, errors in zip(self.groups, moved, strict=True):
            for name in group:
                own = slice(None) if len(group) == 1 else joint_number(name) - 1
                slopes[:, own, column[name]] = (errors - base)[:, own] / self.steps[column[name]]
        return slopes.reshape(-1, len(self.free))


def _lower(robot: Robot, name: str) -> float:
    """No parameter of a servo is negative; a law says of its own."""
    if name not in robot.parameters:
        return 0.0
    bounds = {
        parameter_name(k, effect, p.name): p.lower
        for k, joint in robot.numbered
        for effect in joint.values
        for p in joint.catalogue[effect].parameters
    }
    return bounds.get(name, -np.inf)


def _least(robot: Robot, name: str) -> float:
    """A small value of this kind: what a parameter that starts at zero is measured by."""
    if name.endswith("delay"):
        return 1e-3
    return 1e-2 if name not in robot.parameters or "load" in name else 1e-3


def _jackknife(
    J: np.ndarray, residual: np.ndarray, lengths: Sequence[int], scale: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """(P,) standard deviations from leaving out one log at a time, a Newton step each; infinite on a bound.

    J          (N, P) of the robust loss, as SciPy leaves it: slopes times (1 + z)^(-3/4), z = (r / _ROUGH)²;
               JᵀJ is the loss's Hessian and Jᵀ (1 + z)^(1/4) r its gradient
    residual   (N,) r at the optimum
    lengths    of the logs, in the order of the rows;  scale: (P,) of the parameters
    free       (P,) whether a parameter lies on no bound
    Few logs tell a standard deviation roughly: it is widened, so that 1.96 of them hold 95 % of Student's t.
    """
    from scipy.stats import t

    A = (J * scale)[:, free]
    gradient = (1 + (residual / _ROUGH) ** 2) ** 0.25 * residual
    cuts = np.cumsum(lengths)[:-1]
    parts = list(zip(np.split(A, cuts), np.split(gradient, cuts), strict=True))
    H, g = [a.T @ a for a, _ in parts], [a.T @ r for a, r in parts]
    whole_H, whole_g = sum(H), sum(g)
    moved = np.array([np.linalg.pinv(whole_H - h) @ (b - whole_g) for h, b in zip(H, g, strict=True)])
    n, std = len(parts), np.full(len(scale), np.inf)
    wider = float(t.ppf(0.975, n - 1)) / CONFIDENCE
    std[free] = wider * np.sqrt((n - 1) / n * np.sum((moved - moved.mean(axis=0)) ** 2, axis=0)) * scale[free]
    return std
