"""What the robot's equations say of guessed channels: signs, units, zeros, order and delays."""

from collections.abc import Mapping as Named
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.checks.balances import Balances, balances, samples
from pyident.checks.better_channels import best_change, misfit
from pyident.checks.scale import file_factor
from pyident.checks.signs import against
from pyident.checks.timing import delay
from pyident.checks.transformations import Transformation
from pyident.estimation.lock_unlogged import locked
from pyident.inspection.channel import Channel
from pyident.inspection.guesses import MOTOR_SIDE, natural_unit
from pyident.inspection.motion import by_range, in_degrees, in_parts, in_turns
from pyident.logs.foreign import map_columns
from pyident.logs.log import LogError
from pyident.logs.mapping import Mapping, Source
from pyident.logs.units import FACTORS

_EFFORTS = ("N.m", "mN.m", "kN.m", "N.cm", "kgf.cm")
_DECIMAL = ("N.m", "mN.m", "kN.m")
_RARE = ("N.cm", "kgf.cm")  # of which a torque in per mille of the rated one may have the size
_FORCES = ("N", "kN")
_CLOSE = 2.2  # times that the masses may be off the robot file's where a unit is told from them
_WITNESS = 0.25  # of the torques' variance: with more left, the equations are no witness
_ANGLES = ("rad", "deg", "rev", "mrad")
_BETTER = 0.5  # of the variance left: what another unit of all angles must come below
_SCALES = (0.9, 1.1)  # of all angles at once, that must explain less
_NEARLY = 0.7  # of the variance that they leave: what the angles as they are must come below
_ROUNDS = 6
EXPLAINS = "the robot's masses times"  # of a channel that the equations account for


def mapping_of(channels: list[Channel], rate: float | None = None) -> Mapping:
    """Every channel that is a signal of a log, as it is guessed."""
    signals = {}
    for c in channels:
        if c.name is not None:
            factor = FACTORS[c.unit or "1"]
            signals[c.name] = Source(c.column, c.sign * factor, c.offset * factor, c.delay, c.clock, c.turn)
    return Mapping(signals, rate=None if "time" in signals else rate)


def with_physics(
    channels: list[Channel], raw: Named[str, np.ndarray], robot: Robot, rate: float | None
) -> tuple[list[Channel], list[str]]:
    """The channels as the equations of motion want them, and what was found; raw: column -> (N,)."""
    channels, said = _angles(channels, raw, robot, rate)
    placed = not any(c.guessed for c in channels)
    for _ in range(_ROUNDS):
        of = _balances(channels, raw, robot, rate)
        if of is None:
            return channels, said
        best = best_change(of, placed)
        if best is None or best.change.kind == "sum":
            break
        changed = _applied(channels, best.change, robot)
        if [_read_as(c) for c in changed] == [_read_as(c) for c in channels]:  # no unit is so far off
            break
        said.append(f"{best.change.mend.partition(';')[0]}; the mapping has it (by the robot's equations: "
                    f"{100 * np.sqrt(best.left):.2g} % of the torques are left instead of "
                    f"{100 * np.sqrt(best.now):.2g} %)")  # fmt: skip
        channels = changed
    of = _balances(channels, raw, robot, rate)
    if of is None:
        return channels, said
    channels, flips = _signs(channels, of)
    of = _balances(channels, raw, robot, rate) or of
    channels, late = _delays(channels, of)
    return _degrees(_efforts(channels, of, robot), raw, robot, rate), said + flips + late


def _degrees(
    channels: list[Channel], raw: Named[str, np.ndarray], robot: Robot, rate: float | None
) -> list[Channel]:
    """Without the question whether angles are parts of a range, where any other scale explains far less."""
    asked = {c.column for c in channels if c.doubt == in_parts(c)}
    left = []
    for scale in (1.0, *_SCALES) if asked else ():
        scaled = {name: scale * x if name in asked else x for name, x in raw.items()}
        of = _balances(channels, scaled, robot, rate)
        left.append(misfit(of).share if of is not None else np.inf)
    if not left or left[0] > _WITNESS or min(left[1:]) * _NEARLY < left[0]:
        return channels
    why = "the robot's equations, for which it is in deg"
    return [replace(c, doubt="", sure=True, why=(*c.why, why)) if c.column in asked else c for c in channels]


def _angles(
    channels: list[Channel], raw: Named[str, np.ndarray], robot: Robot, rate: float | None
) -> tuple[list[Channel], list[str]]:
    """Angles whose unit only their range tells, in the unit that explains the torques far better."""
    units = {c.unit for c in channels if by_range(c) and c.unit in _ANGLES}
    if len(units) != 1:
        return channels, []
    now = next(iter(units))
    tried = {unit: [_in_unit(c, now, unit) for c in channels] for unit in _ANGLES}
    left = {}
    for unit, changed in tried.items():
        of = _balances(changed, raw, robot, rate)
        if of is not None:
            left[unit] = misfit(of).share
    best = min(left, key=lambda unit: left[unit], default=now)
    if best == now or now not in left or left[best] > _BETTER * left[now]:
        return channels, []
    told = ", ".join(f"{100 * np.sqrt(share):.2g} % in {unit}" for unit, share in left.items())
    return tried[best], [f"angles are in {best} by the robot's equations, which leave of the torques {told}"]


def _in_unit(c: Channel, old: str, unit: str) -> Channel:
    if not by_range(c) or c.unit != old or unit == old:
        return c
    why = (*c.why, f"the robot's equations, for which it is in {unit}")
    doubt = "" if c.doubt in (in_turns(c), in_degrees(c)) else c.doubt
    return replace(c, unit=unit, sure=not doubt, doubt=doubt, why=why)


def _balances(
    channels: list[Channel], raw: Named[str, np.ndarray], robot: Robot, rate: float | None
) -> Balances | None:
    try:
        log = map_columns(dict(raw), mapping_of(channels, rate), "the recording", robot)
        reduced, _ = locked(robot, [log])
        signals = samples(reduced, log)
        of = balances(signals) if signals is not None else None
    except (LogError, KeyError, ValueError):
        return None
    return of if of is not None and of.joints else None


def _applied(channels: list[Channel], change: Transformation, robot: Robot) -> list[Channel]:
    """The guesses after a change of coordinates and torques."""
    n = len(robot.joints)
    motion, offset, out = change.motion[:n, :n], change.offset[:n], []
    for c in channels:
        k = (c.joint or 0) - 1
        position = c.signal in ("position", "reference")
        effort = c.signal in ("torque", "current", "feedforward", "voltage")
        if not 0 <= k < n or not (position or effort):
            out.append(c)
            continue
        matrix = motion if position else change.torque
        to = int(np.argmax(np.abs(matrix[:, k])))  # our joint that takes this column
        factor = float(matrix[to, k])
        c = replace(c, joint=to + 1, sign=c.sign * (1 if factor > 0 else -1))
        if abs(abs(factor) - 1) > 1e-6:
            c = replace(c, unit=_unit_of(FACTORS[c.unit or "1"] * abs(factor)) or c.unit)
        if position and offset[to]:
            c = replace(c, offset=c.offset + offset[to] / FACTORS[c.unit or "rad"])
        out.append(replace(c, why=(*c.why, change.mend)))
    return out


def _read_as(c: Channel) -> tuple[int | None, float, str | None, float]:
    return c.joint, c.sign, c.unit, c.offset


def _unit_of(factor: float) -> str | None:
    units = ("rad", "deg", "m", "mm")
    return next((unit for unit in units if abs(FACTORS[unit] / factor - 1) < 1e-6), None)


def _signs(channels: list[Channel], of: Balances) -> tuple[list[Channel], list[str]]:
    """Torques against their motion are turned; the question stays where the position may be what is wrong."""
    wrong = {k + 1: reason for k, reason in against(of).items()}
    if not wrong:
        return channels, []
    out = []
    for c in channels:
        if c.signal in ("torque", "current", "voltage") and c.joint in wrong:
            c = replace(c, sign=-c.sign, sure=False, why=(*c.why, wrong[c.joint]),
                        doubt=f"the sign of {c.column} was turned, as otherwise {wrong[c.joint]}; or is it "
                              "the "
                        f"position of joint {c.joint} that has the wrong sign?")  # fmt: skip
        out.append(c)
    return out, [
        f"joint {k}: torque and position have opposite signs: {reason}" for k, reason in wrong.items()
    ]


def _delays(channels: list[Channel], of: Balances) -> tuple[list[Channel], list[str]]:
    late = {k + 1: found.shift * of.samples.period for k in of.joints if (found := delay(of, k)) is not None}
    out = [
        replace(c, delay=round(late[c.joint], 6), why=(*c.why, f"late by {1e3 * late[c.joint]:.3g} ms"))
        if c.joint in late and c.signal in ("torque", "current", "voltage")
        else c
        for c in channels
    ]
    return out, [
        f"the torque of joint {k} is {1e3 * d:.3g} ms late; corrected in the mapping" for k, d in late.items()
    ]


def _efforts(channels: list[Channel], of: Balances, robot: Robot) -> list[Channel]:
    """Units of torques, by the order of magnitude of the robot file's masses."""
    explained = misfit(of).share < _WITNESS
    factor = file_factor(of) if explained else None
    weighed = factor is not None and 1 / _CLOSE < factor < _CLOSE  # friction alone fits any gear
    weighed &= not any(c.signal in ("current", "voltage") and c.joint for c in channels)  # of unknown drives
    weighed &= not any(c.unit == "mrad" and c.doubt.endswith(MOTOR_SIDE) for c in channels)  # deg and a gear
    scaled = factor is not None and any(1 / _CLOSE < FACTORS[u] * factor < _CLOSE for u in _DECIMAL)
    out = []
    for c in channels:
        joint = robot.joints[c.joint - 1] if c.joint and c.joint <= len(robot.joints) else None
        if c.signal != "torque" or joint is None:
            gear, unit_asked = f"{c.column}{MOTOR_SIDE}", (in_turns(c), in_degrees(c))
            if (weighed and c.doubt == gear) or (scaled and c.doubt in unit_asked):
                c = replace(c, doubt="", sure=True, why=(*c.why, "the robot's equations"))
            out.append(c)
            continue
        unit, doubt = c.unit, c.doubt.removesuffix(f"{c.column}{MOTOR_SIDE}")
        doubt = c.doubt if factor is None else doubt
        if factor is not None:
            usual = _EFFORTS if joint.kind == "revolute" else _FORCES
            natural = c.unit or natural_unit("torque", joint.kind)
            near = min(usual, key=lambda u: abs(np.log(FACTORS[u] * factor / FACTORS[natural])))  # pyright: ignore[reportOperatorIssue]
            off = max(r := FACTORS[near] * factor / FACTORS[natural], 1 / r)
            if c.unit is None and off <= _CLOSE and near in _RARE:
                unit = near
                doubt = (f"in {natural}, {c.column} makes the masses {factor:.3g} times the robot file's: "
                         f"is it in {near}, or in parts of a rated torque?")  # fmt: skip
            elif off > _CLOSE:
                doubt = (f"in {natural}, {c.column} makes the masses {factor:.3g} times the robot file's: "
                         "what is "
                         f"its unit, or is a gear ratio missing?")  # fmt: skip
            elif c.unit is None:
                unit = near
            elif near != natural and max(factor, 1 / factor) > _CLOSE:
                doubt = (
                    f"the file says {c.unit} of {c.column}, the robot's masses say {near}: which is right?"
                )
        sure = unit is not None and not doubt and (factor is not None or c.unit is not None)
        why = (*c.why, f"{EXPLAINS} {factor:.2g}") if factor is not None else c.why
        out.append(replace(c, unit=unit, sure=sure, doubt=doubt, why=why))
    return out
