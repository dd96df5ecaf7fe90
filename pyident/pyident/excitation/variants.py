"""Motions that are at hand without a search: variants of an experiment, none further or faster than it."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from flexmodels.experiment import Experiment, identification
from flexmodels.robot import Robot, RobotError
from pyident.logs.log import Log
from pyident.simulation.replay import replay_of

DURATION = 8.0  # s: of every variant
LARGER, SMALLER = 1.5, 0.5  # of the multisine
_FADE = 1.0  # s


def variants(robot: Robot, log: Log | None = None, duration: float = DURATION) -> dict[str, Experiment]:
    """Phrase -> experiment: slower, with more or less multisine, one joint at a time.

    Of the robot's own identification experiment, or of a log's references where it has none; no variant goes
    further or faster than that. Raises RobotError, and LogError for a log without references.
    """
    if robot.settings.identification is not None:
        whole, name = identification(robot), "the identification experiment"
    elif log is not None:
        whole, name = replay_of(robot, log).plan, f"the motion of {log.source}"
    else:
        raise RobotError(
            f"robot {robot.name} has no [identification] experiment and no log was given; add one"
        )
    plan = _first(whole, duration)
    found = {
        name: plan,
        f"{name} at half the speed": _slower(whole, plan, 0.5),
        f"{name} at a quarter of the speed": _slower(whole, plan, 0.25),
    }
    if plan.feedforward.any():
        found |= {
            f"{name} with a multisine {LARGER:g} times as large": _wave(plan, LARGER),
            f"{name} with a multisine {SMALLER:g} times as large": _wave(plan, SMALLER),
            f"{name} without its multisine": _wave(plan, 0.0),
        }
    if len(robot.joints) > 1:
        found |= {f"{name} with joint {k} alone": _alone(plan, k - 1) for k, _ in robot.numbered}
    return found


def at_rest(plan: Experiment) -> Experiment:
    """The same way, begun and ended at rest: time sets in and dies away within a second."""
    lasts = float(plan.time[-1])
    near = np.clip(np.minimum(plan.time, lasts - plan.time) / min(_FADE, lasts / 4), 0, 1)
    rate = near**2 * (3 - 2 * near)
    passed = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(plan.time))])
    reference = CubicSpline(plan.time, plan.reference)(passed)
    return replace(plan, reference=reference, feedforward=rate[:, None] * plan.feedforward)


def _first(plan: Experiment, duration: float) -> Experiment:
    kept = plan.time <= duration * (1 + 1e-9)
    return Experiment(plan.time[kept], plan.reference[kept], plan.feedforward[kept])


def _slower(whole: Experiment, plan: Experiment, speed: float) -> Experiment:
    """The same way, later; the multisine keeps its frequencies."""
    reference = [np.interp(plan.time * speed, whole.time, r) for r in whole.reference.T]
    return replace(plan, reference=np.column_stack(reference))


def _wave(plan: Experiment, share: float) -> Experiment:
    return replace(plan, feedforward=share * plan.feedforward)


def _alone(plan: Experiment, joint: int) -> Experiment:
    """The others stay where they start."""
    still = np.broadcast_to(plan.reference[:1], plan.reference.shape).copy()
    still[:, joint] = plan.reference[:, joint]
    wave = np.zeros_like(plan.feedforward)
    wave[:, joint] = plan.feedforward[:, joint]
    return Experiment(plan.time, still, wave)
