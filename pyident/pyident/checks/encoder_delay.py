"""How much later than the motor encoder the link encoder of an axis is sampled, from the motion itself.

A link encoder read d seconds late adds -d de to the twist. On the link's balance, which knows no friction, no
law looks like that: its coefficient over the stiffness is the delay.
"""

from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import deformation_of, motor_of, of_joint
from flexmodels.robot import Robot
from pyident.conditioning.filters import thin
from pyident.conditioning.weak_form import condition
from pyident.estimation.least_squares import solve_weighted
from pyident.logs.foreign import delayed
from pyident.logs.log import Log
from pyident.regression.reduced import reduce
from pyident.regression.regressor import regressor
from pyident.rules.equation_checks import EQUATIONS


@dataclass(frozen=True)
class Skew:
    """delay [s] of joint `joint`'s link encoder behind its motor encoder, and its standard deviation."""

    joint: int
    delay: float
    std: float


def encoder_skews(robot: Robot, log: Log) -> list[Skew]:
    """Of every joint with a flexible hinge, from one log. Raises LogError."""
    part = condition(log, robot)
    Phi = regressor(robot, part.motion)
    flexible = [k for k, joint in robot.numbered if joint.flexible]
    rows = [Phi.rows.index(deformation_of(k)) for k in flexible]
    late = np.zeros((*Phi.matrix.shape[:2], len(flexible)))
    for i, (k, row) in enumerate(zip(flexible, rows, strict=True)):
        late[:, row, i] = part.motion.dq[:, k - 1]
    use = part.use[:: part.thinning]
    A = thin(np.concatenate([Phi.matrix, late], axis=2), part.thinning) * use[:, :, None]
    y = thin(part.target, part.thinning) * use
    found = solve_weighted(
        reduce([(A, y)], Phi.rows, (*Phi.columns, *(of_joint(k, "late") for k in flexible)))
    )
    p, covariance = found.p, found.covariance
    out = []
    for i, k in enumerate(flexible):
        at = (Phi.columns.index(of_joint(k, "k[1]")), len(Phi.columns) + i)
        stiffness, product = p[at[0]], p[at[1]]
        slope = np.array([-product / stiffness**2, 1 / stiffness])
        std = float(np.sqrt(slope @ covariance[np.ix_(at, at)] @ slope))
        out.append(Skew(k, float(product / stiffness), std))
    return out


def without_skew(log: Log, skews: list[Skew]) -> tuple[Log, list[str]]:
    """The log with late link encoders put right where the delay is certain, and a sentence on each."""
    frame, notes = log.frame, []
    for skew in skews:
        sure = abs(skew.delay) > EQUATIONS.sure_delay * skew.std
        fate = "corrected" if sure else "which this log cannot tell, so it is left as it is"
        notes.append(
            f"joint {skew.joint}: link encoder {1e3 * skew.delay:.3g} ± {1e3 * skew.std:.2g} ms late, {fate}"
        )
        if sure:
            e, eps = motor_of(skew.joint), deformation_of(skew.joint)
            link = frame.assign(**{eps: frame[eps] + frame[e]})
            frame = frame.assign(**{eps: delayed(link, {eps: skew.delay})[eps] - frame[e]})
    return Log(frame, log.source, (*log.notes, *notes)), notes
