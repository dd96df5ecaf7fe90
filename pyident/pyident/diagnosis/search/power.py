"""Whether laws could be what their names say: friction takes power, and a body that moves has energy.

A least squares knows no sign. Beside 15 N m of dry friction it will give 83 N m of difference between the
directions if that is what fits, and the joint would then be driven one way. So friction is taken together,
the model's own and that of the laws, along the motion of the logs. Nor does it know of a body that is held:
what is missing in one log is a body below zero in the others. Its kinetic energy along the motion holds what
the torques tell of it, and no more.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.diagnosis.base.candidates import Candidate, motion_for, slopes
from pyident.regression.candidate_columns import effect_columns
from pyident.regression.spectrum import Equations


def is_friction(robot: Robot, candidate: Candidate) -> bool:
    """Whether a candidate is a law that can only take power."""
    return not candidate.describes and robot.catalogue[candidate.effect].is_friction


def is_body(robot: Robot, candidate: Candidate) -> bool:
    """Whether a candidate is a body at the tip."""
    return not candidate.describes and bool(robot.catalogue[candidate.effect].body)


def knows_sign(robot: Robot, candidate: Candidate) -> bool:
    """Whether the sign of its energy is known."""
    return is_friction(robot, candidate) or is_body(robot, candidate)


def of_wrong_sign(
    robot: Robot,
    logs: Sequence[Equations],
    p: np.ndarray,
    laws: Sequence[tuple[Candidate, np.ndarray]],
    first: Candidate,
) -> float:
    """What no friction puts in, or no body has, over what the first of some laws takes, or has.

    p      (P,) linear parameters of the robot
    laws   candidates beside it, and their coefficients (K,) each
    """
    if is_body(robot, first):
        return energy_below_zero(robot, logs, first, next(x for c, x in laws if c == first))
    return energy_put_in(robot, logs, p, laws, first.joint)


def energy_below_zero(
    robot: Robot, logs: Sequence[Equations], body: Candidate, coefficients: np.ndarray
) -> float:
    """The kinetic energy of a body, coefficients (K,), that lies below zero, as a share of that above.

    At rest torques are M(q) q̈ and weight; put at q̈ = q̇ the first are M(q) q̇, twice the energy per speed.
    """
    below = above = 0.0
    for number, log in enumerate(logs):
        if body.log not in (None, number):
            continue
        motion = log.part.motion
        still = replace(motion, dq=np.zeros_like(motion.dq), ddq=np.zeros_like(motion.dq))
        pushed, weight = (slopes(robot, body, at) for at in (replace(still, ddq=motion.dq), still))
        energy = np.zeros(len(motion.q))
        for x, name in zip(coefficients, pushed, strict=True):
            for row, torque in pushed[name].items():
                energy += 0.5 * x * motion.dq[:, row] * (torque - weight[name][row])
        below += float(np.maximum(-energy, 0.0).sum())
        above += float(np.maximum(energy, 0.0).sum())
    return below / max(above, 1e-300)


def energy_put_in(
    robot: Robot,
    logs: Sequence[Equations],
    p: np.ndarray,
    laws: Sequence[tuple[Candidate, np.ndarray]],
    joint: int,
) -> float:
    """Energy that a joint's friction puts in over the logs, as a share of what it takes.

    p      (P,) linear parameters of the robot
    laws   candidates beside it, and their coefficients (K,) each; those of other joints do not count
    """
    named = dict(zip(robot.linear_parameters, p.tolist(), strict=True))
    own = [(c, x) for c, x in laws if c.joint == joint and is_friction(robot, c)]
    taken = put_in = 0.0
    for log in logs:
        motion, row = log.part.motion, joint - 1
        force = _of_model(robot, joint, motion, named)
        for candidate, x in own:
            columns = slopes(robot, candidate, motion_for(robot, candidate, motion)).values()
            force = force + sum(x * by_row[row] for x, by_row in zip(x, columns, strict=True))
        power = force * motion.dq[:, row] * log.part.use[:, row]
        taken += float(np.maximum(power, 0.0).sum())
        put_in += float(np.maximum(-power, 0.0).sum())
    return put_in / max(taken, 1e-300)


def _of_model(robot: Robot, joint: int, motion: Motion, named: dict[str, float]) -> np.ndarray:
    """(N,) friction of a joint's own laws, with linear parameters of these names."""
    force = np.zeros(len(motion.q))
    for law in robot.joints[joint - 1].effects:
        if law.is_friction:
            for name, by_row in effect_columns(robot, joint, law.name, motion).items():
                force = force + named[parameter_name(joint, law.name, name)] * by_row[joint - 1]
    return force


def impossible(robot: Robot, candidate: Candidate, share: float) -> str:
    """What is said of a law whose energy cannot be, by that share of what it should have."""
    if is_body(robot, candidate):
        return f"it would be a body whose energy lies below zero ({100 * share:.0f} % of what lies above)"
    return f"the joint's friction would drive it: it puts in {100 * share:.0f} % of what it takes"
