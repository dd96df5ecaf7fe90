"""Equations of a joint that hardly moves say nothing of what is missing: its friction has no settled sign.

Coulomb's law jumps at rest. Nothing else does: asperities bend first, and other simulators round the sign
over a speed of their own. Who looks at the slowest samples finds a law of friction that is not Coulomb's, in
any log that this project did not make, and that nobody asked about. Below a speed over which a rounded sign
is settled (tanh 2 = 0.96 with the rounding that laws of this project use), or a tenth of the joint's own
where it is slow throughout, a diagnosis leaves the joint's balance out, in logs and replicas alike.

Nor is the sign known where a joint turns and turns back between two samples. A held torque's equation spans
two periods T, and with the acceleration a the speed may have been zero in them where |v| < |a| T, though no
sample shows it. Under a multisine a light joint does that dozens of times, each with twice its friction.
"""

from dataclasses import replace

import numpy as np
from scipy.ndimage import maximum_filter1d

from flexmodels.effects.effect import SLOW
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.logs.log import Log

_SETTLED = 2 * SLOW  # rad/s
_LEVER = 0.1  # m: a slider's speed is that of a hinge at this distance
_OWN = 0.1  # of the joint's rms speed: more than that is never left out


def settled(log: Log, robot: Robot) -> Conditioned:
    """The conditioned log without the motors' equations at which dry friction has no settled sign.

    Raises LogError.
    """
    part = condition(log, robot)
    use = part.use.copy()
    for k, joint in robot.numbered:
        if any(effect.holds_still for effect in joint.effects):
            v, a = np.abs(part.motion.dq[:, k - 1]), np.abs(part.motion.ddq[:, k - 1])
            speed = _SETTLED * (_LEVER if joint.kind == "prismatic" else 1.0)
            unsettled = v < min(speed, _OWN * float(np.sqrt(np.mean(v**2))))
            if part.motion.tau_before is not None:
                unsettled |= v < log.period * maximum_filter1d(a, 3)
            use[unsettled, k - 1] = 0.0
    return replace(part, use=use)
