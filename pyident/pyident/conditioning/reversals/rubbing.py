"""Where a robot's dry friction acts: what slides there, and which equations hold its torque.

A joint's own friction turns its sign with the joint. A shaft that two motors turn has the sign of a sum of
their speeds, and its friction stands in the equations of both.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from sympy import Expr

from flexmodels.coordinate import signal_of
from flexmodels.effects import signals
from flexmodels.effects.effect import SLOW
from flexmodels.effects.rubbing import Sum, rubbing
from flexmodels.robot import Robot
from pyident.conditioning.reversals.rest import away_from_rest


@dataclass(frozen=True)
class Rub:
    """Two parts that slide on each other.

    rows    equations (from 0, in `robot.coordinates`) in which their dry friction stands
    shares  (joints,) of the joints' speeds in that at which they slide, the largest ± 1
    width   of that speed, over which their law rounds the sign
    """

    rows: tuple[int, ...]
    shares: np.ndarray
    width: float

    def of(self, joints: np.ndarray) -> np.ndarray:
        """(N,) how fast or how far they slide, from speeds or positions (N, joints or more)."""
        return joints[:, : len(self.shares)] @ self.shares


def speed_products(dq: np.ndarray, joints: int) -> np.ndarray:
    """(joints, joints) means of the products of two joints' speeds over all samples, dq (N, n)."""
    return dq[:, :joints].T @ dq[:, :joints] / max(len(dq), 1)


def signs_known(robot: Robot, speeds: np.ndarray, products: np.ndarray) -> np.ndarray:
    """(N, n): 1 where everything that rubs in an equation keeps its direction around a sample, else 0.

    speeds    (N, n) at the samples
    products  of the whole log, as of `speed_products`
    """

    def known(rub: Rub) -> np.ndarray:
        mean_square = max(float(rub.shares @ products @ rub.shares), 0.0)
        return away_from_rest(rub.of(speeds), mean_square, rub.width)

    return known_where(robot, known, speeds.shape)


def known_where(robot: Robot, known: Callable[[Rub], np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """(N, n): 1 where `known` (N,) says so of everything that rubs in an equation, else 0."""
    use = np.ones(shape)
    for rub in rubs(robot):
        use[:, rub.rows] *= known(rub)[:, None]
    return use


def rubs(robot: Robot) -> list[Rub]:
    """Everything that rubs, each pair of parts once."""
    rows = {coordinate.signal: row for row, coordinate in enumerate(robot.q)}
    found: dict[tuple[tuple[float, ...], float], set[int]] = {}
    for k, joint in robot.numbered:
        for effect in joint.effects:
            for coordinate, sums in rubbing(effect).items():
                for factors in sums:
                    slides = _sliding(robot, k, factors, joint.values[effect.name])
                    found.setdefault(slides, set()).add(rows[signal_of(k, coordinate.name)])
    slide = [(shares, width, at) for (shares, width), at in found.items() if any(shares)]
    return [Rub(tuple(sorted(at)), np.array(shares), width) for shares, width, at in slide]


def _sliding(
    robot: Robot, k: int, factors: Sum, values: Mapping[str, float]
) -> tuple[tuple[float, ...], float]:
    """Shares and width of a sum of speeds at joint k; values: of its law's parameters."""
    named = {signal_of(k, speed.name): _value(factor, values) for speed, factor in factors.items()}
    largest = max(abs(value) for value in named.values()) or 1.0
    speeds = (coordinate.rate(1) for coordinate in robot.q[: len(robot.joints)])
    own = set(factors) == {signals.de}
    return tuple(named.get(speed, 0.0) / largest for speed in speeds), 0.0 if own else SLOW / largest


def _value(factor: Expr, values: Mapping[str, float]) -> float:
    """Of a speed's factor, at the law's parameters."""
    known: dict[Any, float] = {s: values[str(s)] for s in factor.free_symbols}
    return float(factor.subs(known))
