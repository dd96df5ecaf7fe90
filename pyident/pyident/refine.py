"""Output error in closed loop: the model, simulated on the log's own reference, is made to follow the log.

Derivatives of measured signals play no part, so what they bias is gone. Each round linearises the simulated
outputs in the parameters (Gauss-Newton) and solves the same kind of least-squares problem as the regression,
with the outputs (e, eps, tau) for rows. Directions that the regression did not see are left alone.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from pyident.identify import Identified, identified
from pyident.log import Log, LogError
from pyident.physical import lower_bounds
from pyident.solve import Reduced, Solution, reduce, solve

Simulate = Callable[[Experiment, Sequence[Mapping[str, float]]], Iterable[pd.DataFrame]]
Progress = Callable[[float], None]

_STEP = 1e-5  # of the length of the scaled parameters: finite difference
_ROUNDS, _LINEARISED = 6, 2  # rounds in all; rounds that renew the sensitivities
_SETTLED = 1e-3  # of a standard deviation: change at which the rounds end


@dataclass(frozen=True)
class Sensitivity:
    """d(outputs)/d(parameters) of one log's simulation: (M, channels, P), zero in unseen directions."""

    slopes: np.ndarray


def refine(
    robot: Robot,
    logs: list[Log],
    start: Identified,
    simulate: Simulate,
    sensitivities: list[Sensitivity] | None = None,
    progress: Progress | None = None,
) -> tuple[Identified, list[Sensitivity]]:
    """Improve `start` until the simulated outputs no longer come nearer to the logs.

    simulate       runs the robot's FMU over an experiment, once per set of parameters, in their order
    sensitivities  of an earlier call on the same motion, to save their calculation
    Raises LogError when a log has no reference.
    """
    plans = [experiment_of(robot, log) for log in logs]
    measured = [log.signals(channels(robot)) for log in logs]
    best, slopes, renew = start, sensitivities, _LINEARISED if sensitivities is None else 0
    for number in range(_ROUNDS):
        p = _operating_point(robot, best)
        share = number / _ROUNDS
        if number < renew or slopes is None:
            slopes = [
                _sensitivity(robot, plan, p, start.solution, simulate, _scaled(progress, share)) for plan in plans
            ]
        residuals = [
            y - next(iter(simulate(plan, [p])))[list(channels(robot))].to_numpy()
            for plan, y in zip(plans, measured, strict=True)
        ]
        fitted = _solve(robot, p, residuals, slopes)
        change = np.abs(fitted.p - np.array(list(best.robot.parameters.values())))
        best = _with_solution(robot, best, fitted, slopes, p, residuals)
        settled = (change[~fitted.open] <= _SETTLED * fitted.std[~fitted.open]).all()
        if progress:
            progress((number + 1) / _ROUNDS)
        if settled and number >= renew:
            break
    assert slopes is not None
    return best, slopes


def channels(robot: Robot) -> tuple[str, ...]:
    """The outputs that are compared: every coordinate and every motor torque."""
    return (*robot.coordinates, *(f"joint{k}.tau" for k, _ in robot.numbered))


def experiment_of(robot: Robot, log: Log) -> Experiment:
    """The experiment that the log records. Raises LogError when it has no reference."""
    for k, _ in robot.numbered:
        if f"joint{k}.r" not in log.frame:
            raise LogError(f"{log.source}: column joint{k}.r is missing, the reference that a simulation follows")
    joints = [k for k, _ in robot.numbered]
    feedforward = [
        log.frame.get(f"joint{k}.tau_ff", pd.Series(0.0, index=log.frame.index)).to_numpy() for k in joints
    ]
    time = log.signals(["time"])[:, 0]
    return Experiment(time - time[0], log.signals([f"joint{k}.r" for k in joints]), np.column_stack(feedforward))


def _operating_point(robot: Robot, found: Identified) -> dict[str, float]:
    """The parameters, with those that must not be negative a finite difference away from zero."""
    length = np.linalg.norm(found.solution.p * found.solution.scale)
    floors = {name: 10 * _STEP * length for name, lower in lower_bounds(robot).items() if lower == 0}
    scale = dict(zip(found.reduced.columns, found.solution.scale, strict=True))
    return {
        name: max(value, floors[name] / scale[name]) if name in floors else value
        for name, value in found.robot.parameters.items()
    }


def _sensitivity(
    robot: Robot,
    plan: Experiment,
    p: Mapping[str, float],
    regression: Solution,
    simulate: Simulate,
    progress: Progress | None,
) -> Sensitivity:
    """Forward differences along every direction that the regression saw."""
    names, outputs = list(p), list(channels(robot))
    values, scale = np.array(list(p.values())), regression.scale
    step = _STEP * np.linalg.norm(regression.p * scale)
    directions = regression.seen.T
    sets = [dict(zip(names, values + step * d / scale, strict=True)) for d in directions]
    runs = iter(simulate(plan, [p, *sets]))
    base = next(runs)[outputs].to_numpy()
    slopes = np.empty((*base.shape, len(directions)))
    for i, frame in enumerate(runs):
        slopes[:, :, i] = (frame[outputs].to_numpy() - base) / step
        if progress:
            progress((i + 1) / len(directions))
    return Sensitivity((slopes @ directions) * scale)


def _solve(
    robot: Robot, p: Mapping[str, float], residuals: list[np.ndarray], slopes: list[Sensitivity]
) -> Solution:
    """One Gauss-Newton round; each channel weighs by the residual that it has left."""
    reduced = _reduced(robot, p, residuals, slopes)
    solution = solve(reduced, _weights(residuals))
    return solve(reduced, 1 / np.maximum(solution.residual, 1e-9 * np.maximum(solution.signal, 1e-300)))


def _reduced(
    robot: Robot, p: Mapping[str, float], residuals: list[np.ndarray], slopes: list[Sensitivity]
) -> Reduced:
    values = np.array(list(p.values()))
    blocks = ((s.slopes, r + s.slopes @ values) for r, s in zip(residuals, slopes, strict=True))
    return reduce(blocks, channels(robot), tuple(p))


def _weights(residuals: list[np.ndarray]) -> np.ndarray:
    rms = np.sqrt(np.mean(np.concatenate(residuals) ** 2, axis=0))
    return 1 / np.maximum(rms, 1e-12 * rms.max())


def _with_solution(
    robot: Robot,
    before: Identified,
    solution: Solution,
    slopes: list[Sensitivity],
    p: Mapping[str, float],
    residuals: list[np.ndarray],
) -> Identified:
    """The identified robot of this round; support and torque error stay those of the regression's kind."""
    found = identified(robot, _reduced(robot, p, residuals, slopes), solution)
    return replace(found, relative_error=before.relative_error)


def _scaled(progress: Progress | None, start: float) -> Progress | None:
    return None if progress is None else lambda fraction: progress(start + fraction / _ROUNDS)
