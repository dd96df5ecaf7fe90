"""Torques that hold another gravity than the robot file's, or none: an arm on a wall, a weight taken out.

Many drives report what is left after their own compensation of the weight. Masses cannot make up for that:
what falls with them also has inertia. Φ is linear in gravity, so that every other direction is tried by one
least squares of all joints.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.checks.balances import Balances, balances, solved
from pyident.checks.defect import Defect
from pyident.checks.scale import shared
from pyident.rules.log_checks import LOG_CHECKS

_AXES = {f"{'-+'[s > 0]}{name}": s * e for name, e in zip("xyz", np.eye(3), strict=True) for s in (-1, 1)}
_ROWS = 400  # samples are enough to tell directions apart


def gravity(of: Balances, source: str) -> Iterator[Defect]:
    """At most one defect: the torques fit far better without gravity, or with one along another axis.

    It is gross where little is left then.
    """
    robot = of.samples.robot
    size = float(np.linalg.norm(robot.gravity))
    if size == 0 or len(of.joints) < 2 or _left(of) < LOG_CHECKS.material**2:
        return
    few = of.samples.every(max(1, len(of.samples.at) // _ROWS))
    now = _left(of_few := balances(few))
    none = balances(replace(few, robot=_with(robot, np.zeros(3))))
    per_axis = [balances(replace(few, robot=_with(robot, size * e))).Phi - none.Phi for e in np.eye(3)]
    tried = {"": np.zeros(3)} | _AXES
    left = {}
    for name, direction in tried.items():
        Phi = none.Phi + sum(part * along for part, along in zip(per_axis, direction, strict=True))
        left[name] = _left(_with_matrix(of_few, Phi))
    best = min(left, key=lambda name: left[name])
    if left[best] >= LOG_CHECKS.far_better * now:
        return
    without = "gravity along " + best if best else "no gravity"
    cure = "its direction (gravity in the robot file)" if best else (
        "whether the torques were logged without what holds the weight, and log them whole, or let the robot "
        "file say gravity = [0, 0, 0]")  # fmt: skip
    severity = "gross" if left[best] < LOG_CHECKS.material**2 else "doubtful"
    yield Defect(severity, "gravity", "",
                 f"{source}: with {without} the model leaves {_percent(left[best])} % of the torques, with "
                 f"the robot file's {_percent(now)} %; check {cure}")  # fmt: skip


def _left(of: Balances) -> float:
    """Energy that one set of parameters leaves of all joints' torques, over their variances; a mean."""
    normal, right, energy = shared(of, of.joints)
    b = right.sum(axis=0)
    p = solved(normal.sum(axis=0), b)[0]
    return max(float(energy.sum() - b @ p), 0.0) / len(of.joints)


def _with(robot: Robot, gravity: np.ndarray) -> Robot:
    return replace(robot, gravity=tuple(gravity.tolist()))


def _with_matrix(of: Balances, Phi: np.ndarray) -> Balances:
    normal = np.zeros_like(of.normal)
    for k in of.joints:
        A = Phi[of.samples.use[:, k] > 0, k]
        normal[k] = A.T @ A
    return replace(of, Phi=Phi, normal=normal)


def _percent(energy: float) -> str:
    return f"{100 * np.sqrt(energy):.2g}"
