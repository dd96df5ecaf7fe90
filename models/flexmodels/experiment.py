"""What a robot is told to do: references and feed-forward torques over time."""

import casadi as ca
import numpy as np
from scipy.optimize import least_squares

from flexmodels import multisine
from flexmodels.inputs import Experiment
from flexmodels.mechanics import dynamics
from flexmodels.robot import Robot, RobotError
from flexmodels.settings.motions import Line

__all__ = ["Experiment", "identification", "line", "line_profile"]
_MOST_SAMPLES = 5_000_000  # some 83 minutes at 1 kHz, and most of a GB of memory for six joints


def identification(
    robot: Robot, seed: int = 0, duration: float | None = None, flat: bool = False
) -> Experiment:
    """The paper's section 3: every joint swings, a multisine excites the flexibilities.

    seed    of the random phases;  duration [s], none: the robot file's
    flat    optimise the phases for a small peak (crest factor) instead of leaving them random
    Raises RobotError.
    """
    plan = robot.settings.identification
    if plan is None:
        raise RobotError(f"robot {robot.name} has no [identification] experiment; add one or give a file")
    time = _grid(robot, duration or plan.duration)
    phase = 2 * np.pi * time / plan.period
    reference = np.outer(1 - np.cos(phase), np.array(plan.swing) / 2)
    tones = plan.multisine
    frequencies = np.linspace(tones.lowest, tones.highest, tones.lines)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, (len(robot.joints), tones.lines))
    if flat:
        phases = np.array([multisine.flattened(p, frequencies) for p in phases])
    waves = np.column_stack([multisine.wave(time, frequencies, p) for p in phases])
    return Experiment(time, reference, waves * np.array(tones.rms))


def line(robot: Robot) -> Experiment:
    """The paper's validation: the tip of the rigid robot follows a straight line, at rest at both ends.

    Raises RobotError.
    """
    plan = robot.settings.line
    if plan is None:
        raise RobotError(f"robot {robot.name} has no [line] experiment; add one or give a file")
    time = _grid(robot, plan.duration)
    path = np.array(plan.start) + np.outer(
        line_profile(time / plan.duration), np.subtract(plan.end, plan.start)
    )
    return Experiment(time, _inverse_kinematics(robot, plan, path), np.zeros((len(time), len(robot.joints))))


def line_profile(share: np.ndarray) -> np.ndarray:
    """Share of the way [0, 1] at a share of the time: at rest, without jump of acceleration, at both ends."""
    return 10 * share**3 - 15 * share**4 + 6 * share**5


def _grid(robot: Robot, duration: float) -> np.ndarray:
    if robot.controller is None:
        raise RobotError(f"robot {robot.name} has no [controller], so it cannot be simulated; add one")
    period = robot.controller.period
    if not duration / period < _MOST_SAMPLES:
        raise RobotError(
            f"robot {robot.name}: {duration:g} s at controller.rate {1 / period:g} Hz are more than "
            f"{_MOST_SAMPLES:g} samples; take a shorter motion or a lower rate"
        )
    return np.arange(round(duration / period) + 1) * period


def _inverse_kinematics(robot: Robot, plan: Line, path: np.ndarray) -> np.ndarray:
    """Joint references (N, joints) whose rigid tip follows the path (N, 3); shortest posture at the start."""
    m = dynamics.mechanism(robot)
    moving = [k - 1 for k, _ in robot.numbered if k not in plan.locked]
    tip = ca.Function("tip", [m.q], [dynamics.tip_position(m)])

    def miss(e: np.ndarray, target: np.ndarray) -> np.ndarray:
        q = np.zeros(m.q.numel())
        q[moving] = e
        return np.array(tip(q)).ravel() - target

    starts = np.random.default_rng(0).uniform(-np.pi, np.pi, (40, len(moving)))
    found = [least_squares(miss, e, args=(path[0],), xtol=1e-14, ftol=1e-14, gtol=1e-14) for e in starts]
    reached = [f.x for f in found if np.linalg.norm(f.fun) < 1e-9]
    if not reached:
        raise RobotError(f"robot {robot.name} cannot reach {plan.start}, where [line] starts")
    e = min((np.arctan2(np.sin(x), np.cos(x)) for x in reached), key=np.linalg.norm)
    reference = np.zeros((len(path), len(robot.joints)))
    for i, target in enumerate(path):
        solution = least_squares(miss, e, args=(target,), xtol=1e-14, ftol=1e-14, gtol=1e-14)
        if np.linalg.norm(solution.fun) > 1e-9:
            raise RobotError(f"robot {robot.name} cannot follow [line]: {target.round(3)} is out of reach")
        e = solution.x
        reference[i, moving] = e
    return reference
