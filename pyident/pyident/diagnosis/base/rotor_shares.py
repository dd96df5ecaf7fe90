"""The share of a joint's inertia that is its rotor's, where only a law of the load can tell.

A regression leaves half of it to the link, for no reason. Friction that grows with the load is then put to a
load with a false inertial part, and explains a fraction of what it should. So the share is taken with which
it explains most, if that is more than chance makes of any other. The model's own torques stay the same.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, bounds, columns
from pyident.diagnosis.base.projection import Base, extended, gain
from pyident.regression.loads.bodies import carries_friction
from pyident.regression.loads.rotor_share import OpenShare, open_shares
from pyident.regression.spectrum import Equations

_LAW = "load_dependent_friction"
_TRIED = 9  # shares, before the best is refined
_FINE = 0.01  # of the whole range


def with_rotor_shares(
    robot: Robot, logs: Sequence[Equations], base: Base, levels: Sequence[np.ndarray], chance: float
) -> Robot:
    """The fitted robot with the shares that the logs tell; base: theirs;  levels: per log (n, E) of floors.

    chance   standard deviations by which a gain differs by chance
    """
    for share in open_shares(robot, [log.part.motion for log in logs]):
        if not carries_friction(robot.joints[share.joint - 1]):
            robot = _told(robot, share, logs, base, levels, chance)
    return robot


def _told(
    robot: Robot,
    share: OpenShare,
    logs: Sequence[Equations],
    base: Base,
    levels: Sequence[np.ndarray],
    chance: float,
) -> Robot:
    law, constant = (Candidate(name, share.joint) for name in (_LAW, "offset"))
    if constant.effect not in robot.joints[share.joint - 1].values:
        base = extended(base, columns(robot, constant, logs, levels))

    def explained(by: float) -> float:
        X = columns(share.moved(robot, by), law, logs, levels)
        return gain(base, X, *bounds(robot, law)).energy

    tried = np.linspace(*share.ends, _TRIED)
    energy = [explained(by) for by in tried.tolist()]
    best = int(np.argmax(energy))
    around = tried[max(best - 1, 0)], tried[min(best + 1, _TRIED - 1)]
    found: Any = minimize_scalar(
        lambda by: -explained(by), bounds=around, method="bounded", options={"xatol": _FINE * np.ptp(tried)}
    )
    most, as_fitted = max(-float(found.fun), energy[best]), explained(0.0)
    by = float(found.x) if -found.fun >= energy[best] else float(tried[best])
    sure = np.sqrt(most) - np.sqrt(as_fitted) > chance
    return share.moved(robot, by) if sure else robot
