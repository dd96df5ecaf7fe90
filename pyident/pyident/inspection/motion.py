"""Positions and velocities must agree: that tells their units, signs and, without names, which is which."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.inspection.channel import PLACE, Channel
from pyident.logs.turns import TURNS, unwrapped, whole_turn
from pyident.logs.units import FACTORS, KINDS

_AGREES = 0.9  # correlation of a velocity with the derivative of its position
_CLOSE = 0.15  # relative error of a ratio of units
_PRECISE = 0.03  # the same of units that are hardly ever used together
_LIKE = 0.98  # correlation of a reference with its position
DERIVATIVE = "one block of columns is the derivative of another"
_DEGREES = 8.0  # rad: an angle that goes farther is hardly in radians
_TURN = 1.0  # within a turn either way: if all angles of a recording stay in it, they may be in turns
_PARTS = 100.5  # to which others, LeRobot among them, scale the range of a joint
_SYMBOL = re.compile(r"(?<![a-z])(q|qpos|phi|theta)(?![a-z])", re.IGNORECASE)  # of mechanics, in radians
_SPEEDS = ("rad/s", "deg/s", "rpm", "rev/s")
_ESTIMATE = re.compile(r"pos_estimate", re.IGNORECASE)  # of a drive that counts in turns (ODrive)
RANGE = "its range up to"  # of a position whose unit nothing else tells


def with_motion_units(channels: list[Channel], robot: Robot | None, period: float | None) -> list[Channel]:
    """Units of positions, references and velocities, by their ranges and by each other."""
    out = list(channels)
    speeds = {(c.joint, c.side): c for c in out if c.signal == "velocity"}
    for i, c in enumerate(out):
        if c.signal not in ("position", "reference") or c.joint is None:
            continue
        prismatic = robot is not None and c.joint <= len(robot.joints) and (
            robot.joints[c.joint - 1].kind == "prismatic"
        )  # fmt: skip
        speed = speeds.get((c.joint, c.side)) if c.signal == "position" else None
        out[i] = _position(c, speed, prismatic, period, robot is not None)
    units = {c.unit for c in out if c.signal == "position" and c.sure and c.unit}
    for i, c in enumerate(out):
        if c.signal in ("position", "reference") and not c.sure and len(units) == 1 and c.joint is not None:
            other = next(iter(units))
            if c.unit is not None and (c.unit == other or KINDS[other] == KINDS[c.unit]):
                asked = "" if c.doubt == in_degrees(c) else c.doubt
                why = (*c.why, "the unit of the other positions")
                out[i] = replace(c, unit=other, sure=not asked, doubt=asked, why=why)
    return _not_in_parts(_not_in_turns(out))


def with_whole_turns(c: Channel) -> Channel:
    """An angle that was wrapped to a turn without its jumps, which tell its unit."""
    turn = whole_turn(c.values) if c.signal in ("position", "reference") else None
    if turn is None or c.unit not in (None, TURNS[turn]):
        return c
    why = (*c.why, f"jumps of a whole turn, {turn:.4g}")
    return replace(c, values=unwrapped(c.values, turn), turn=turn, unit=TURNS[turn], why=why)


def by_range(c: Channel) -> bool:
    """Whether nothing but its range tells the unit of an angle."""
    return c.signal in ("position", "reference") and any(why.startswith(RANGE) for why in c.why)


def _not_in_turns(channels: list[Channel]) -> list[Channel]:
    """With a question where angles that only their range places might be turns as well as radians."""
    ranged = [c for c in channels if by_range(c) and c.unit == "rad" and c.joint is not None]
    angles = [c for c in ranged if not _SYMBOL.search(c.column)]
    if not angles or max(_reach(c) for c in angles) > _TURN:
        angles = [c for c in angles if _ESTIMATE.search(c.column)]
    asked = {c.column: in_turns(c) for c in angles}
    return [
        replace(c, sure=False, doubt=c.doubt or asked[c.column]) if c.column in asked else c for c in channels
    ]


def _not_in_parts(channels: list[Channel]) -> list[Channel]:
    """With a question where angles that only their range places in degrees might be parts of that range."""
    ranged = [c for c in channels if by_range(c) and c.unit == "deg" and c.joint is not None]
    told = any(c.signal == "position" and c.unit == "deg" and not by_range(c) for c in channels)
    if told or not ranged or max(_reach(c) for c in ranged) > _PARTS:
        return channels
    asked = {c.column for c in ranged}
    return [
        replace(c, sure=False, doubt=c.doubt or in_parts(c)) if c.column in asked else c for c in channels
    ]


def in_parts(c: Channel) -> str:
    """The question of an angle that stays within -100 to 100."""
    return (
        f"is {c.column} in degrees, or in parts of its range from -100 to 100 (then: gain, in rad per part, "
        f"and offset)? it reaches {_reach(c):.3g}"
    )


def in_turns(c: Channel) -> str:
    """The question of an angle that stays within a turn."""
    return f"is {c.column} in radians or turns? it reaches {_reach(c):.3g}"


def in_degrees(c: Channel) -> str:
    """The question of an angle that goes far for radians and not far for degrees."""
    return f"is {c.column} in radians or degrees? it reaches {_reach(c):.3g}"


def _reach(c: Channel) -> float:
    return max(abs(c.low), abs(c.high))


def _position(
    c: Channel, speed: Channel | None, prismatic: bool, period: float | None, known: bool
) -> Channel:
    """Unit of a position: as the file says, by its velocity, or by its range."""
    if c.unit is not None:
        return replace(c, sure=not c.doubt)
    if speed is not None and period and len(speed.values) == len(c.values) and speed.unit is not None:
        ratio, agreement = _slope(c.values, speed.values * FACTORS[speed.unit], period)
        for unit in ("rad", "deg", "rev", "mrad") if not prismatic else ("m", "mm"):
            if abs(agreement) > _AGREES and abs(abs(ratio) / FACTORS[unit] - 1) < _CLOSE:
                turned = f"{c.column} has the sign opposite to {speed.column}: which of them is right?"
                doubt = c.doubt or ("" if ratio > 0 else turned)
                why = (*c.why, "the derivative that its velocity is")
                return replace(c, unit=unit, sure=not doubt, doubt=doubt, why=why)
    unit = _by_unlike(c, speed, period) if not prismatic else None
    if unit is not None and speed is not None:
        why = (*c.why, f"the derivative that {speed.column} is in another unit")
        return replace(c, unit=unit, sure=not c.doubt, why=why)
    reach = _reach(c)
    whole = bool((c.values == np.round(c.values)).all()) and reach > 50
    if whole:
        return replace(c, unit=None, doubt=f"{c.column} holds whole numbers up to {reach:g}: how many "
                                           "counts make a "
                       "turn (gain, in rad per count), and which is zero (offset)?")  # fmt: skip
    if prismatic:
        unit = "mm" if reach > 5 else "m"
        return replace(c, unit=unit, sure=known and not 2 < reach < 20, why=(*c.why, f"{RANGE} {reach:.3g}"))
    unit = "rad" if reach < _DEGREES else "deg"
    sure = (reach < np.pi + 0.5 and np.ptp(c.values) > 0.02) or _DEGREES * 2 < reach < 400
    doubt = c.doubt or ("" if sure else in_degrees(c))
    return replace(c, unit=unit, sure=not doubt, doubt=doubt, why=(*c.why, f"{RANGE} {reach:.3g}"))


def _by_unlike(c: Channel, speed: Channel | None, period: float | None) -> str | None:
    """The unit of an angle whose speed is as many times its derivative as two units make: rev and rpm."""
    if speed is None or not period or speed.unit is not None:
        return None
    ratio, agreement = _slope(c.values, speed.values, period)
    if abs(agreement) <= _AGREES:
        return None
    unlike = [
        (abs(abs(ratio) * FACTORS[other] / FACTORS[unit] - 1), unit)
        for unit in ("rad", "deg", "rev")
        for other in _SPEEDS
        if abs(FACTORS[unit] / FACTORS[other] - 1) > _CLOSE
    ]
    off, unit = min(unlike)
    return unit if off < _PRECISE else None


def with_velocities_found(channels: list[Channel], period: float | None) -> list[Channel]:
    """Velocities without a unit: by their positions'."""
    places = {(c.joint, c.side): c for c in channels if c.signal == "position" and c.unit}
    out = []
    for c in channels:
        place = places.get((c.joint, c.side)) if c.signal == "velocity" else None
        if place is not None and c.unit is None and period and len(place.values) == len(c.values):
            ratio, agreement = _slope(place.values * FACTORS[place.unit or "1"], c.values, period)
            units = _SPEEDS if KINDS[place.unit or "rad"] == "angle" else ("m/s", "mm/s")
            best = min(units, key=lambda unit: abs(abs(ratio) * FACTORS[unit] - 1))
            if abs(agreement) > _AGREES and abs(abs(ratio) * FACTORS[best] - 1) < _CLOSE:
                c = replace(c, unit=best, sure=True, sign=1 if ratio > 0 else -1,
                            why=(*c.why, f"the derivative of {place.column}"))  # fmt: skip
        out.append(c)
    return out


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
            fits = [
                abs(_slope(channels[i].values, channels[j].values, period)[1])
                for i, j in zip(first, second, strict=True)
            ]
            if a != b and np.median(fits) > _AGREES and b not in kind:
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
        fits = [
            abs(_slope(channels[free[i]].values, channels[free[i + n]].values, period)[1])
            for i in range(min(n, len(free) - n))
        ]
        if fits and np.median(fits) > _AGREES:
            return n
    return 0


def _slope(q: np.ndarray, v: np.ndarray, period: float) -> tuple[float, float]:
    """v per dq/dt, and their correlation, both smoothed a little."""
    if len(q) != len(v) or np.ptp(q) == 0 or np.ptp(v) == 0:
        return 0.0, 0.0
    box = np.ones(5) / 5
    rate = np.convolve(np.gradient(q, period), box, "valid")
    smooth = np.convolve(v, box, "valid")
    if np.ptp(rate) == 0:
        return 0.0, 0.0
    agreement = float(np.corrcoef(rate, smooth)[0, 1])
    return float(np.sum(rate * smooth) / np.sum(rate**2)), agreement if np.isfinite(agreement) else 0.0


def _roughness(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.diff(x, 2) ** 2)) / max(float(np.std(x)), 1e-300))
