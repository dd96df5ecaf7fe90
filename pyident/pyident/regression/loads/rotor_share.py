"""How much of a joint's inertia is its rotor's: where no torque tells, a law that reads the load may.

A rigid joint whose axis no joint before it turns has an inertia J_m + M of which only the sum is in the
equations. The load that its transmission carries is without J_m, though: friction that grows with the load
knows where the rotor ends and the link begins.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.joint import parameter_name
from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.links import LinkColumns
from pyident.regression.loads.bodies import link_torques

_SAMPLES = 200  # of each motion: whether two columns are one shows in any of them
_ALIKE = 1e-6
_TENSOR = [name for name in LINK_PARAMETERS if name.startswith("J[")]


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
    link = _of_axis(axis)
    first = len(LINK_PARAMETERS) * (k - 1)
    for motion in motions:
        own = np.zeros((len(motion.q), len(robot.joints)))
        own[:, k - 1] = motion.ddq[:, k - 1]
        most = float(np.abs(own).max())
        if most == 0 or np.abs(_asked(robot, motion, first, link) - own).max() > _ALIKE * most:
            return None
    names = [f"link{k}.{name}" for name in LINK_PARAMETERS]
    change = {rotor: 1.0} | {n: -w for n, w in zip(names, link, strict=True) if w}
    if not set(change) <= set(robot.linear_parameters):
        return None
    least = min(float(_own_inertia(robot, k, motion).min()) for motion in motions)
    all_of_it = robot.parameters[rotor] + least
    return OpenShare(k, change, (-robot.parameters[rotor], least)) if all_of_it > 0 else None


def _of_axis(axis: np.ndarray) -> np.ndarray:
    """(10,) a link's parameters if all that it has is 1 kg m² about an axis through its origin."""
    tensor = {f"J[{'xyz'[i]}{'xyz'[j]}]": axis[i] * axis[j] for i in range(3) for j in range(i, 3)}
    return np.array([tensor.get(name, 0.0) for name in LINK_PARAMETERS])


def _asked(robot: Robot, motion: Motion, first: int, link: np.ndarray) -> np.ndarray:
    """(N, joints) what a link with parameters (10,), which begin at `first`, asks of the joints."""
    columns = LinkColumns(robot, [len(LINK_PARAMETERS) * i for i in range(len(robot.links))])
    Phi = np.zeros((len(motion.q), len(robot.coordinates), len(LINK_PARAMETERS) * len(robot.links)))
    rates = [np.ascontiguousarray(rate, float) for rate in (motion.q, motion.dq, motion.ddq)]
    columns.fill(Phi, (rates[0], rates[1], rates[2]))
    return Phi[:, : len(robot.joints), first : first + len(link)] @ link


def _own_inertia(robot: Robot, k: int, motion: Motion) -> np.ndarray:
    """(N,) [kg m²] of the links about joint k's axis: the diagonal element of their mass matrix."""
    still = np.zeros_like(motion.q)
    turned = still.copy()
    turned[:, k - 1] = 1.0
    torques = [link_torques(robot, Motion(motion.q, still, ddq)) for ddq in (turned, still)]
    return (torques[0] - torques[1])[:, k - 1]


def _thinned(motion: Motion) -> Motion:
    step = max(1, len(motion.q) // _SAMPLES)
    return Motion(motion.q[::step], motion.dq[::step], motion.ddq[::step])
