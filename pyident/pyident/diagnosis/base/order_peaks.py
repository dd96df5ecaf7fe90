"""Periods of a joint's turn that stand out of a residual: where a search for periodic laws should begin.

Gears, bearings and motors repeat hundreds of times a turn, too finely for a grid that knows nothing; and a
torque of which the joint does not pass a whole period is a spring or a hose as well as a ripple. The
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
    whole       the order of one period within the angles that the joint passes; inf: no period shows
    """

    steady: list[float]
    friction: list[float]
    whole: float

    def beside(self, grid: Sequence[dict[str, float]], law: Effect) -> list[dict[str, float]]:
        """The grid of a law's nonlinear values, and if it is periodic these orders, too.

        Friction is friction however slowly it changes along the range; of a torque a whole period must show.
        """
        if law.order is None:
            return list(grid)
        name = law.order.name
        if law.order_of_torque is None:
            return [*grid, *({**grid[0], name: order} for order in self.friction)]
        if not np.isfinite(self.whole):
            return []
        least = max(law.order.lower, self.whole)
        above = [values for values in grid if values[name] > least]
        return [*above, *({**grid[0], name: order} for order in (least, *self.steady))]


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
        shows = _span(angles) >= 2 * np.pi / rules.highest
        found[k] = Orders(
            steady=_peaks(steady, angles, orders, rules),
            friction=_peaks(turning, angles, orders, rules),
            whole=2 * np.pi / _span(angles) if shows else np.inf,
        )
    return found


def _orders(
    angles: Sequence[np.ndarray], speeds: np.ndarray, period: float, rules: PeriodicRules
) -> np.ndarray:
    """Those that the motion resolves and the sampling follows; may be none."""
    span = _span(angles)
    moving = speeds[speeds > 0.1 * speeds.max()] if speeds.max() > 0 else speeds[:0]
    if span <= 0 or not len(moving):
        return np.zeros(0)
    top = min(rules.highest, rules.fastest * np.pi / period / float(np.median(moving)))
    return np.arange(max(rules.lowest, 4 * np.pi / span), top, 2 * np.pi / span / _PER_PEAK)


def _span(angles: Sequence[np.ndarray]) -> float:
    """Of the angles of several logs, the widest range of one."""
    return max(float(np.ptp(q)) for q in angles)


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
