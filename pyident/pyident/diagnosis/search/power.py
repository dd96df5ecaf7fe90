"""Whether the friction of a joint, with further laws, takes power: it cannot drive.

A least squares knows no sign. Beside 15 N m of dry friction it will give 83 N m of difference between the
directions if that is what fits, and the joint would then be driven one way. So friction is taken together,
the model's own and that of the laws, along the motion of the logs.
"""

from collections.abc import Sequence

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
