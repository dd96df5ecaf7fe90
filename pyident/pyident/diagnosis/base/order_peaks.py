"""Periods of a joint's turn that stand out of a residual: where a search for periodic laws should begin.

Gears, bearings and motors repeat hundreds of times a turn, too finely for a grid that knows nothing. The
residual of a joint's equation is held against cos nφ and sin nφ of its angle for every order n that the
motion resolves and the sampling can follow; an order counts against the median of its neighbours, and
against all that were tried. Waves of friction turn round with the motion.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from flexmodels.effects.effect import Effect
from flexmodels.robot import Robot
from pyident.regression.regressor import residual_of
from pyident.regression.spectrum import Equations
from pyident.rules.periodic import PeriodicRules

_PER_PEAK = 3.0  # orders tried per resolved one
_MEDIAN = float(np.log(2))  # of an exponential variable, per its mean
_BLOCK = 64  # orders at once


@dataclass(frozen=True)
class Orders:
    """Of a joint, per turn, or per 2 pi metres of a slider; the strongest first.

    steady      of a torque that the angle alone decides;  friction: of one that turns round with the motion
    """

    steady: list[float]
    friction: list[float]

    def beside(self, grid: Sequence[dict[str, float]], law: Effect) -> list[dict[str, float]]:
        """The grid of a law's nonlinear values, and if it is periodic these orders, too."""
        if law.order is None:
            return list(grid)
        further = self.friction if law.is_friction else self.steady
        return [*grid, *({**grid[0], law.order.name: order} for order in further)]


def order_peaks(
    robot: Robot, logs: Sequence[Equations], p: np.ndarray, rules: PeriodicRules, joints: Iterable[int]
) -> dict[int, Orders]:
    """Orders of each of the joints (from 1). p (P,): parameters that leave the residual."""
    left = [residual_of(robot, log.part, p) for log in logs]
    found = {}
    for k in joints:
        angles = [log.part.motion.q[:, k - 1] for log in logs]
        speeds = [log.part.motion.dq[:, k - 1] for log in logs]
        orders = _orders(angles, np.abs(np.concatenate(speeds)), logs[0].band.period, rules)
        steady = [r[:, k - 1] for r in left]
        turning = [r * np.sign(v) for r, v in zip(steady, speeds, strict=True)]
        found[k] = Orders(*(_peaks(r, angles, orders, rules) for r in (steady, turning)))
    return found


def _orders(
    angles: Sequence[np.ndarray], speeds: np.ndarray, period: float, rules: PeriodicRules
) -> np.ndarray:
    """Those that the motion resolves and the sampling follows; may be none."""
    span = max(float(np.ptp(q)) for q in angles)
    moving = speeds[speeds > 0.1 * speeds.max()] if speeds.max() > 0 else speeds[:0]
    if span <= 0 or not len(moving):
        return np.zeros(0)
    top = min(rules.highest, rules.fastest * np.pi / period / float(np.median(moving)))
    return np.arange(max(rules.lowest, 4 * np.pi / span), top, 2 * np.pi / span / _PER_PEAK)


def _peaks(
    left: Sequence[np.ndarray], angles: Sequence[np.ndarray], orders: np.ndarray, rules: PeriodicRules
) -> list[float]:
    if len(orders) < rules.neighbours:
        return []
    energy = np.zeros(len(orders))
    for r, q in zip(left, angles, strict=True):
        energy += _energies(r, q, orders)
    typical = median_filter(energy, rules.neighbours, mode="reflect")
    ratio = energy / np.maximum(typical / _MEDIAN, 1e-300)
    chance = np.log(len(orders) / rules.chance) * (1 + len(left)) / 2  # of a mean over logs, at most
    out: list[float] = []
    for i in np.argsort(-ratio):
        if ratio[i] < chance or len(out) == rules.peaks:
            break
        if all(abs(orders[i] - other) > 2 * _PER_PEAK * (orders[1] - orders[0]) for other in out):
            out.append(float(orders[i]))
    return out


def _energies(r: np.ndarray, q: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """|Σ r exp(i order q)|² at equidistant orders: a wave is one of the first few times that of its block."""
    first = np.exp(1j * np.outer(orders[:_BLOCK] - orders[0], q))
    blocks = r[:, None] * np.exp(1j * np.outer(q, orders[::_BLOCK]))
    return np.square(np.abs(first @ blocks)).T.ravel()[: len(orders)]
