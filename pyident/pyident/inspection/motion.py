"""Positions and velocities must agree: that tells their units and signs."""

import re
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.inspection.channel import Channel
from pyident.logs.turns import TURNS, unwrapped, whole_turn
from pyident.logs.units import FACTORS, KINDS

AGREES = 0.9  # correlation of a velocity with the derivative of its position
CLOSE = 0.15  # relative error of a ratio of units
PRECISE = 0.03  # the same of units that are hardly ever used together
_DEGREES = 8.0  # rad: an angle that goes farther is hardly in radians
_MANY = 5  # turns: a joint seldom makes more
_TURN = 1.0  # within a turn either way: if all angles of a recording stay in it, they may be in turns
_PARTS = 100.5  # to which others, LeRobot among them, scale the range of a joint
_SYMBOL = re.compile(r"(?<![a-z])(q|qpos|phi|theta)(?![a-z])", re.IGNORECASE)  # of mechanics, in radians
SPEEDS = ("rad/s", "deg/s", "rpm", "rev/s")
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
        f"is {c.column} in degrees, in radians or turns of several turns, or in parts of its range from "
        f"-100 to 100 (then: gain, in rad per part, and offset)? it reaches {_reach(c):.3g}"
    )


def in_turns(c: Channel) -> str:
    """The question of an angle that stays within a turn."""
    return f"is {c.column} in radians or turns? it reaches {_reach(c):.3g}"


def in_degrees(c: Channel) -> str:
    """The question of an angle that goes far for radians and not far for degrees."""
    return f"is {c.column} in radians or degrees? it reaches {_reach(c):.3g}"


def _reach(c: Channel) -> float:
    return max(abs(c.low), abs(c.high))


def _of_many_turns(c: Channel) -> str:
    """The question of an angle that turns as a motor does before its gear; empty for any other."""
    turns = (c.high - c.low) * FACTORS[c.unit or "rad"] / (2 * np.pi)
    return (
        f"{c.column} turns {turns:.0f} times: is it the motor's, before a gear? (gear)"
        if turns > _MANY
        else ""
    )


def _position(
    c: Channel, speed: Channel | None, prismatic: bool, period: float | None, known: bool
) -> Channel:
    """Unit of a position: as the file says, by its velocity, or by its range."""
    if c.unit is not None:
        doubt = c.doubt or ("" if prismatic or c.side == "motor" else _of_many_turns(c))
        return replace(c, sure=not doubt, doubt=doubt)
    if speed is not None and period and len(speed.values) == len(c.values) and speed.unit is not None:
        ratio, agreement = slope(c.values, speed.values * FACTORS[speed.unit], period)
        for unit in ("rad", "deg", "rev", "mrad") if not prismatic else ("m", "mm"):
            if abs(agreement) > AGREES and abs(abs(ratio) / FACTORS[unit] - 1) < CLOSE:
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
    ratio, agreement = slope(c.values, speed.values, period)
    if abs(agreement) <= AGREES:
        return None
    unlike = [
        (abs(abs(ratio) * FACTORS[other] / FACTORS[unit] - 1), unit)
        for unit in ("rad", "deg", "rev")
        for other in SPEEDS
        if abs(FACTORS[unit] / FACTORS[other] - 1) > CLOSE
    ]
    off, unit = min(unlike)
    return unit if off < PRECISE else None


def with_velocities_found(channels: list[Channel], period: float | None) -> list[Channel]:
    """Velocities without a unit: by their positions'."""
    places = {(c.joint, c.side): c for c in channels if c.signal == "position" and c.unit}
    out = []
    for c in channels:
        place = places.get((c.joint, c.side)) if c.signal == "velocity" else None
        if place is not None and c.unit is None and period and len(place.values) == len(c.values):
            ratio, agreement = slope(place.values * FACTORS[place.unit or "1"], c.values, period)
            units = SPEEDS if KINDS[place.unit or "rad"] == "angle" else ("m/s", "mm/s")
            best = min(units, key=lambda unit: abs(abs(ratio) * FACTORS[unit] - 1))
            if abs(agreement) > AGREES and abs(abs(ratio) * FACTORS[best] - 1) < CLOSE:
                c = replace(c, unit=best, sure=True, sign=1 if ratio > 0 else -1,
                            why=(*c.why, f"the derivative of {place.column}"))  # fmt: skip
        out.append(c)
    return out


def slope(q: np.ndarray, v: np.ndarray, period: float) -> tuple[float, float]:
    """v (N,) per dq/dt, at samples every period [s], and their correlation, both smoothed a little."""
    if len(q) != len(v) or np.ptp(q) == 0 or np.ptp(v) == 0:
        return 0.0, 0.0
    box = np.ones(5) / 5
    rate = np.convolve(np.gradient(q, period), box, "valid")
    smooth = np.convolve(v, box, "valid")
    if np.ptp(rate) == 0:
        return 0.0, 0.0
    agreement = float(np.corrcoef(rate, smooth)[0, 1])
    return float(np.sum(rate * smooth) / np.sum(rate**2)), agreement if np.isfinite(agreement) else 0.0
