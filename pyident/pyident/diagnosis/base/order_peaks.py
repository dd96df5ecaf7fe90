"""Periods of a joint's turn that stand out of a residual: where a search for periodic laws should begin.

Gears, bearings and motors repeat hundreds of times a turn, too finely for a grid that knows nothing; and a
torque of which the joint passes fewer than three periods is a spring or a hose as well as a ripple: beside a
line a hose bends twice. Waves of friction turn round with the motion.

What a gear does n times a turn comes at n times the speed: a loop answers it, and an arm shakes with it, as
they do at that frequency. A resonance makes it large at one speed and turns its phase round; and a phase that
lags on the way there leads on the way back. Where no controller says what a loop does, such a wave is
several, each between two speeds. Only what comes as often as teeth do: with a size of its own forward and
backward, a wave of few periods is friction over the angle as well.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import deformation_of
from flexmodels.effects import signals
from flexmodels.effects.effect import Effect
from flexmodels.robot import Robot
from pyident.conditioning.order_waves import (
    highest_of,
    lowest_order,
    orders_within,
    peaks_at_speeds,
    peaks_of,
)
from pyident.regression.regressor import residual_of
from pyident.regression.spectrum import Equations
from pyident.rules.confidence import PERIODS
from pyident.rules.periodic import PeriodicRules

_CLOSEST = 0.02  # of the fastest speed: knots


@dataclass(frozen=True)
class Orders:
    """Of a joint, per turn, or per 2 pi metres of a slider; the strongest first.

    steady      of a torque that the angle alone decides;  friction: of one that turns round with the motion
    twist       of a drive's torque that the angle decides, as an error of its transmission makes
    answered    of a torque whose size and phase are those of the speed, too
    speeds      from fast backward to fast forward, between which such a wave changes [rad/s]
    least       the order of which the joint passes `PERIODS`, enough to be called so; inf: none shows
    """

    steady: list[float]
    twist: list[float]
    friction: list[float]
    answered: list[float]
    speeds: tuple[float, ...]
    least: float

    def beside(self, grid: Sequence[dict[str, float]], law: Effect) -> list[dict[str, float]]:
        """The grid of a law's nonlinear values, and if it is periodic these orders, too.

        Friction is friction however slowly it changes along the range; a torque must repeat. An error of a
        transmission turns the spring alone, as no hose does: of that a period is enough. What shows best
        with a size of its own at every speed may be either: friction turns its phase round with the motion.
        """
        if law.order is None:
            return list(grid)
        name = law.order.name
        if law.order_of_torque is None:
            return [*grid, *({**grid[0], name: order} for order in (*self.friction, *self.answered))]
        if not np.isfinite(self.least):
            return []
        of_drive = signals.eps[1] in law.forces
        least = max(law.order.lower, self.least / PERIODS if of_drive else self.least)
        above = [values for values in grid if values[name] > least]
        seen = self.twist if of_drive else self.steady
        return [*above, *({**grid[0], name: order} for order in (least, *seen, *self.answered))]


def order_peaks(
    robot: Robot, logs: Sequence[Equations], p: np.ndarray, rules: PeriodicRules, joints: Iterable[int]
) -> dict[int, Orders]:
    """Orders of each of the joints (from 1). p (P,): parameters that leave the residual."""
    left = [residual_of(robot, log.part, p) for log in logs]
    found = {}
    for k in joints:
        angles = [log.part.motion.q[:, k - 1] for log in logs]
        speeds = [log.part.motion.dq[:, k - 1] for log in logs]
        highest = highest_of(robot.joints[k - 1], rules)
        orders = orders_within(angles, np.abs(np.concatenate(speeds)), logs[0].band.period, highest, rules)
        steady = [r[:, k - 1] for r in left]
        turning = [r * np.sign(v) for r, v in zip(steady, speeds, strict=True)]
        least = lowest_order(angles)
        twist = deformation_of(k)
        drive = [r[:, robot.coordinates.index(twist)] for r in left] if twist in robot.coordinates else []
        found[k] = Orders(
            steady=peaks_of(steady, angles, orders, rules),
            twist=peaks_of(drive, angles, orders, rules) if drive else [],
            friction=peaks_of(turning, angles, orders, rules),
            answered=peaks_at_speeds(steady, angles, speeds, orders[orders >= rules.teeth], rules),
            speeds=_knots(np.concatenate(speeds), rules.speeds),
            least=least if least <= highest else np.inf,
        )
    return found


def _knots(speeds: np.ndarray, count: int) -> tuple[float, ...]:
    """As many samples at each, but no two closer than a fiftieth of the fastest: a joint may rest."""
    out: list[float] = []
    for v in np.quantile(speeds, (np.arange(count) + 0.5) / count).tolist():
        if not out or v - out[-1] > _CLOSEST * np.abs(speeds).max():
            out.append(v)
    return tuple(out)


def between(knots: Sequence[float], x: np.ndarray) -> np.ndarray:
    """(K, N): of x (N,) 1 at one of K knots, 0 at the others, linear between; the outer ones hold beyond."""
    return np.array([np.interp(x, knots, one) for one in np.eye(len(knots))])


def orders_told(robot: Robot, joint: int, orders: Sequence[float]) -> str:
    """Orders of a joint (from 1), of 2 pi of its coordinate, as "12, 24 per turn"; of a slider per metre."""
    turns = robot.joints[joint - 1].kind == "revolute"
    each = ", ".join(f"{order / (1 if turns else 2 * np.pi):.4g}" for order in orders)
    return f"{each} per {'turn' if turns else 'metre'}"
