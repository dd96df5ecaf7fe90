"""How much of a joint's inertia is its rotor's: where no torque tells, a law that reads the load may.

A rigid joint whose axis no joint before it turns has an inertia J_m + M of which only the sum is in the
equations. The load that its transmission carries is without J_m, though: friction that grows with the load
knows where the rotor ends and the link begins.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.loads.bodies import link_torques

_SAMPLES = 200  # of each motion: whether two columns are one shows in any of them
_ALIKE = 1e-6


@dataclass(frozen=True)
class OpenShare:
    """What a joint's equations leave open.

    joint    from 1
    change   parameter -> its change when the rotor takes over 1 kg m² from the link
    ends     least and largest change [kg m²]: no rotor, no link
    """

    joint: int
    change: Mapping[str, float]
    ends: tuple[float, float]

    def moved(self, robot: Robot, by: float) -> Robot:
        """The robot whose rotor has so much more [kg m²], and its link so much less."""
        return robot.with_parameters({n: robot.parameters[n] + by * c for n, c in self.change.items()})


def open_shares(robot: Robot, motions: Sequence[Motion]) -> list[OpenShare]:
    """Of every rigid revolute joint whose rotor cannot be told from its link along these motions."""
    few = [_thinned(motion) for motion in motions]
    return [share for k, _ in robot.numbered if (share := _open_share(robot, k, few)) is not None]


def _open_share(robot: Robot, k: int, motions: Sequence[Motion]) -> OpenShare | None:
    joint, rotor = robot.joints[k - 1], parameter_name(k, "motor_inertia", "J_m")
    if joint.flexible or joint.kind != "revolute" or rotor not in robot.linear_parameters:
        return None
    axis = np.array(joint.x) / np.linalg.norm(joint.x)
    change = {rotor: 1.0} | {f"link{k}.{name}": -value for name, value in _about(axis).items() if value}
    if not set(change) <= set(robot.linear_parameters):
        return None
    least = min(_least_inertia(robot, k, motion) for motion in motions)
    share = OpenShare(k, change, (-robot.parameters[rotor], least))
    found = share.ends[0] < share.ends[1] and all(_is_open(robot, share, motion) for motion in motions)
    return share if found else None


def _is_open(robot: Robot, share: OpenShare, motion: Motion) -> bool:
    """Whether what the link loses is what the rotor gains, and no other joint sees it."""
    fall = link_torques(robot, motion) - link_torques(share.moved(robot, 1.0), motion)
    gained = np.zeros_like(fall)
    gained[:, share.joint - 1] = motion.ddq[:, share.joint - 1]
    most = float(np.abs(gained).max())
    return most > 0 and bool(np.abs(fall - gained).max() <= _ALIKE * most)


def _about(axis: np.ndarray) -> dict[str, float]:
    """Inertia parameters of a body that has 1 kg m² about an axis through its origin, and nothing else."""
    return {f"J[{'xyz'[i]}{'xyz'[j]}]": axis[i] * axis[j] for i in range(3) for j in range(i, 3)}


def _least_inertia(robot: Robot, k: int, motion: Motion) -> float:
    """[kg m²] of the links about joint k's axis: the least diagonal element of their mass matrix."""
    still = np.zeros_like(motion.q)
    turned = still.copy()
    turned[:, k - 1] = 1.0
    turning, resting = (link_torques(robot, Motion(motion.q, still, ddq)) for ddq in (turned, still))
    return float((turning - resting)[:, k - 1].min())


def _thinned(motion: Motion) -> Motion:
    step = max(1, len(motion.q) // _SAMPLES)
    return Motion(motion.q[::step], motion.dq[::step], motion.ddq[::step])
