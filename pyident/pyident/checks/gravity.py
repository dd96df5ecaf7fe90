"""Torques that hold another gravity than the robot file's, or none: an arm on a wall, a weight taken out.

Many drives report what is left after their own compensation of the weight. Masses cannot make up for that:
what falls with them also has inertia. Φ is linear in gravity, so that every other direction is tried by one
least squares of all joints. What a hose at a joint explains as well speaks for no other gravity, unless the
file has none.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.checks.balances import Balances, balances, balances_of
from pyident.checks.better_channels import misfit
from pyident.checks.defect import Defect
from pyident.rules.log_checks import LOG_CHECKS

_AXES = {f"{'-+'[s > 0]}{name}": s * e for name, e in zip("xyz", np.eye(3), strict=True) for s in (-1, 1)}
_EARTH = 9.81  # m/s2
_ROWS = 400  # samples are enough to tell directions apart


def gravity(of: Balances, source: str) -> Iterator[Defect]:
    """At most one defect: the torques fit far better with another gravity, along another axis, or with none.

    It is gross where much is left as it is, and little then; masses of a light arm may hide that it has none.
    """
    robot = of.samples.robot
    own = float(np.linalg.norm(robot.gravity))
    size = own or _EARTH
    material = misfit(of).material
    if len(of.joints) < 2 or not (material or own):
        return
    few = of.samples.every(max(1, len(of.samples.at) // _ROWS))
    as_is = balances(few)
    now = misfit(as_is)
    none = balances(replace(few, robot=_with(robot, np.zeros(3))))
    if not material and misfit(none).share >= LOG_CHECKS.far_better * now.share:
        return
    per_axis = [balances(replace(few, robot=_with(robot, size * e))).Phi - none.Phi for e in np.eye(3)]

    def turned(direction: np.ndarray) -> Balances:
        Phi = none.Phi + sum(part * along for part, along in zip(per_axis, direction, strict=True))
        return balances_of(few, Phi, of.columns)

    directions = ({"": np.zeros(3)} if own else {}) | _AXES
    tried = {name: turned(direction) for name, direction in directions.items()}
    left = {name: misfit(one) for name, one in tried.items()}
    best = min(left, key=lambda name: left[name].share)
    if best and not material:
        return
    if left[best].share >= LOG_CHECKS.far_better * now.share:
        return
    if (
        own
        and misfit(tried[best].beside_hoses).share >= LOG_CHECKS.far_better * misfit(as_is.beside_hoses).share
    ):
        return
    without = "gravity along " + best if best else "no gravity"
    cure = "its direction (gravity in the robot file)" if best else (
        "whether the torques were logged without what holds the weight, and log them whole, or let the robot "
        "file say gravity = [0, 0, 0]")  # fmt: skip
    severity = "doubtful" if left[best].material or not material else "gross"
    leaves, left_now = (f"{100 * np.sqrt(m.share):.2g} %" for m in (left[best], now))
    yield Defect(severity, "gravity", "",
                 f"{source}: with {without} the model leaves {leaves} of the torques, with the robot file's "
                 f"{left_now}; check {cure}")  # fmt: skip


def _with(robot: Robot, gravity: np.ndarray) -> Robot:
    return replace(robot, gravity=tuple(gravity.tolist()))
