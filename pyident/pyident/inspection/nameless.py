"""Columns without names: which block of them is positions, velocities, torques, by how they move."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.inspection.channel import PLACE, Channel
from pyident.inspection.motion import AGREES, CLOSE, PRECISE, SPEEDS, slope
from pyident.logs.units import FACTORS

_LIKE = 0.98  # correlation of a reference with its position
_RATIOS = {1.0, 1e-3, 1e3, *(FACTORS[a] / FACTORS[b] for a in ("rad", "deg", "rev") for b in SPEEDS)}
DERIVATIVE = "one block of columns is the derivative of another"


def nameless(channels: list[Channel], robot: Robot | None, period: float | None) -> list[Channel]:
    """Columns without names, as blocks of one column per joint: positions, then their velocities and torques.

    A velocity is the derivative of the column a block before; of what is left, the roughest block is torque.
    Where names tell the positions, only what moves like these is guessed: it is their reference.
    """
    free = [i for i, c in enumerate(channels) if c.signal == "unknown" and np.ptp(c.values) > 0]
    places = {c.joint: c.values for c in channels if c.signal == "position" and c.joint is not None}
    if places:
        return _wanted(channels, free, places)
    n = len(robot.joints) if robot else _block(channels, free, period)
    if not free or not n or len(free) < n or period is None:
        return channels
    blocks = [free[i : i + n] for i in range(0, len(free) - n + 1, n)]
    kind, derived = _kinds(channels, blocks, period)
    out = list(channels)
    commanded = next((b for b, signal in kind.items() if signal == "reference"), None)
    for b, signal in kind.items():
        for k, i in enumerate(blocks[b], start=1):
            why = (PLACE, f"how it moves: {signal}", *((DERIVATIVE,) if b in derived else ()))
            doubt = ""
            if commanded is not None and signal in ("position", "reference"):
                other = blocks[commanded if signal == "position" else _position_block(kind)][k - 1]
                alike = f"{out[i].column} and {out[other].column} move alike"
                doubt = f"{alike}: which was measured, which commanded?"
            out[i] = replace(out[i], signal=signal, joint=k, why=why, doubt=doubt)  # pyright: ignore
    return out


def _position_block(kind: dict[int, str]) -> int:
    return next(b for b, signal in kind.items() if signal == "position")


def _wanted(channels: list[Channel], free: list[int], places: dict[int, np.ndarray]) -> list[Channel]:
    """Columns that say no signal and move like a joint's position are its reference."""
    out = list(channels)
    for i in free:
        likeness = {k: _alike(channels[i].values, q) for k, q in places.items()}
        best = max(likeness, key=lambda k: likeness[k])
        others = [value for k, value in likeness.items() if k != best]
        if likeness[best] > _LIKE and all(value < _LIKE for value in others):
            doubt = f"is {channels[i].column} the reference of joint {best}? it moves alike, no name says so"
            why = (f"how it moves: as joint {best}",)
            out[i] = replace(channels[i], signal="reference", joint=best, why=why, doubt=doubt)
    return out


def _kinds(
    channels: Sequence[Channel], blocks: list[list[int]], period: float
) -> tuple[dict[int, str], set[int]]:
    """Block -> signal, and the blocks of which one is the derivative of another."""
    kind: dict[int, str] = {}
    for a, first in enumerate(blocks):
        for b, second in enumerate(blocks):
            pairs = list(zip(first, second, strict=True))
            if a != b and b not in kind and _derives(channels, pairs, period):
                kind.setdefault(a, "position")
                kind[b] = "velocity" if kind[a] == "position" else "acceleration"
    derived = set(kind)
    rest = [b for b in range(len(blocks)) if b not in kind]
    rough = {b: np.median([_roughness(channels[i].values) for i in blocks[b]]) for b in rest}
    smooth = sorted(rest, key=lambda b: rough[b])
    if "position" not in kind.values() and smooth:
        kind[smooth.pop(0)] = "position"
    for b in list(smooth):
        pairs = zip(blocks[_position_block(kind)], blocks[b], strict=True)
        if np.median([_alike(channels[i].values, channels[j].values) for i, j in pairs]) > _LIKE:
            kind[b] = "reference"
            smooth.remove(b)
    if smooth:
        kind[smooth[-1]] = "torque"
    return kind, derived


def _alike(x: np.ndarray, y: np.ndarray) -> float:
    """Their correlation; of columns of other lengths over the same time, too."""
    if np.ptp(x) == 0 or np.ptp(y) == 0:
        return 0.0
    if len(x) != len(y):
        x = np.interp(np.linspace(0, 1, len(y)), np.linspace(0, 1, len(x)), x)
    agreement = float(np.corrcoef(x, y)[0, 1])
    return agreement if np.isfinite(agreement) else 0.0


def _block(channels: Sequence[Channel], free: list[int], period: float | None) -> int:
    """Columns of a block where the robot is not known: the lag at which columns are derivatives."""
    if period is None:
        return 0
    for n in range(1, len(free) // 2 + 1):
        pairs = [(free[i], free[i + n]) for i in range(min(n, len(free) - n))]
        if _derives(channels, pairs, period):
            return n
    return 0


def _derives(channels: Sequence[Channel], pairs: list[tuple[int, int]], period: float) -> bool:
    """Whether the second of most pairs is the derivative of the first, by one ratio that units make.

    A torque goes with the derivative of a velocity, but by a ratio of its own at every joint.
    """
    fits = [slope(channels[i].values, channels[j].values, period) for i, j in pairs]
    if np.median([abs(agreement) for _, agreement in fits]) <= AGREES:
        return False
    ratios = np.array([abs(ratio) for ratio, agreement in fits if abs(agreement) > AGREES])
    return any(
        np.median(np.abs(ratios / known - 1)) < (CLOSE if known == 1 or len(ratios) > 1 else PRECISE)
        for known in _RATIOS
    )


def _roughness(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.diff(x, 2) ** 2)) / max(float(np.std(x)), 1e-300))
