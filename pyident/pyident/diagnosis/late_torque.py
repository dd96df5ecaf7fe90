"""One joint's torque that came another way than its motion: late as a whole, or through a filter of its own.

Across a reversal dry friction makes a torque a step, of which a slope (`torque_lag`) says little where the
torque is late by more than a few samples, or smeared: laws with a memory, as presliding, then take more of
it. So where what was named leaves something that stands out, every measured torque is moved in time, and
taken as before a low pass of a drive's, and the time or the corner is sought that leaves least of its
equation, over a floor that went the same way. It has to leave hardly anything of what exceeds the floor
there, far less than the laws do, and every log by itself has to tell the same.

A digital loop holds a torque until the next one, so that it acts half a sample after it is logged, or less
where not every sample is logged. Where a law or an error says so of one torque, this is put right, too.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from flexmodels.coordinate import joint_number
from flexmodels.robot import Robot
from pyident.conditioning.alignment import HELD, LATEST, NOTHING, Alignment, OwnWay
from pyident.diagnosis.base.candidates import Candidate, law_of
from pyident.diagnosis.imitators.answer import follows_torque
from pyident.diagnosis.search.search import Search
from pyident.refinement.instruments.stand_in import driven
from pyident.regression.descriptions import DESCRIPTIONS

_HIGHEST = 0.8  # of the Nyquist frequency: corners above are none
_EXACT = 0.05  # of a step of a grid
_CORNERS = 12
_SHORT = 2.0  # samples: of less a slope tells all
_LONGER = 2.0  # times what its slope tells, that a delay may be
_ALIKE = 0.25  # of the time, and a sample: as far as logs differ in what they tell
_CLEARLY = 0.95  # of what the best delay leaves, where a low pass is believed


def own_ways(search: Search, named: Sequence[Candidate]) -> tuple[OwnWay, ...]:
    """Those of the torques that came another way than their motion. The search must rest on nothing.

    named   laws that explain the search best
    """
    if search.examination.setting.simulates:
        return ()
    beside = search.resting_on(named)
    open_joints = [k for k, _ in search.robot.numbered if beside.standing_out[k - 1]]
    found = (_way(search, k, beside.remaining_on([k - 1])) for k in open_joints)
    ways = {way.joint: way for way in found if way is not None}
    return tuple((_held(beside) | ways).values())


def held_alike(search: Search, named: Sequence[Candidate]) -> Alignment:
    """That all torques of a flexible robot are held, where one of them is named early by half a sample or
    less.

    One loop holds them all. The fit says so, too, unless it is bent by what is missing at another joint.
    """
    setting = search.examination.setting
    known = driven(setting.robot) or setting.alignment.needed
    if not setting.simulates or known:
        return NOTHING
    held = list(_held_times(search.resting_on(named), named).values())
    return Alignment.by_clock(setting.robot, held[0], setting.period) if held else NOTHING


def less_left(search: Search, again: Search, further: Alignment, named: Sequence[Candidate]) -> bool:
    """Whether logs of which more was put right leave far less at joints whose torques had come by more than a
    hold; and, where all torques are held, at all joints whose torque is not named late by more.

    A burst that a move took to where equations are left out is there again once these are chosen anew.
    """
    search = search.resting_on(())
    before, after = search.lacking, again.resting_on(()).lacking
    most, held = 1 - search.rules.explained[0], HELD * search.examination.setting.period
    moved = [way.joint - 1 for way in further.own if abs(way.behind) > held]
    if (after[moved] > most * before[moved]).any():
        return False
    if further == replace(NOTHING, own=further.own):
        return True
    late = {c.joint for c in named if comes_late(search.robot, c)}
    late -= _held_times(search.resting_on(named), named).keys()
    rows = [row for row, c in enumerate(search.robot.coordinates) if joint_number(c) not in late]
    return bool(after[rows].sum() <= most * before[rows].sum())


def time_of(beside: Search, joint: int, slope: float) -> float:
    """Time [s] by which the torque of a joint (from 1) is late, by what leaves least of its equation: a slope
    tells less of a delay the longer it is. The search must rest on all that is named but that torque.

    slope   what the slope tells [s], which stands where it is short, or the two are not of one kind
    """
    period = beside.examination.setting.period
    if abs(slope) < _SHORT * period:
        return slope
    every = range(len(beside.examination.logs))
    best, left = _best(beside, _kinds(joint, period)[0], every)
    ends = sorted((slope, _LONGER * slope))
    better = left < _left(beside, OwnWay(joint, late=slope), every)  # nowhere, of what the floor holds
    return best.late if better and ends[0] < best.late < ends[1] else slope


def _held(beside: Search) -> dict[int, OwnWay]:
    """By joint the torques that are named late by no more than a loop holds them: that is no one's fault.

    beside   rests on what was named
    """
    times = _held_times(beside, beside.chosen)
    return {joint: OwnWay(joint, -early) for joint, early in times.items()}


def _held_times(beside: Search, named: Sequence[Candidate]) -> dict[int, float]:
    """By joint the time [s] by which a torque is named early, of those that are by no more than a hold.

    beside   rests on what was named
    """
    early = {c.joint: _early(beside.without(c), c) for c in named if comes_late(beside.robot, c)}
    period = beside.examination.setting.period
    return {joint: time for joint, time in early.items() if 0 < time <= HELD * period}


def _early(beside: Search, late: Candidate) -> float:
    """Time [s] that what was named says a torque is logged before it acts."""
    coefficient = float(beside.gain_of(late).coefficients[0])
    if late.describes:
        return -coefficient
    law = law_of(beside.robot, late)
    values = [(p.symbol, value) for p, (_, value) in zip(law.nonlinear, late.values, strict=True)]
    slopes = [float(state.coefficients[0].subs(values)) for state in law.states]
    return sum(-coefficient / slope for slope in slopes)


def comes_late(robot: Robot, candidate: Candidate) -> bool:
    """Whether it says that a torque comes late, as a law or as an error of the file."""
    if candidate.describes:
        return DESCRIPTIONS[candidate.effect].causal
    return follows_torque(robot, candidate)


def _way(search: Search, joint: int, by_laws: float) -> OwnWay | None:
    """Of the torque of a joint (from 1), of which laws leave an energy; None where the logs do not tell."""
    ex = search.examination
    period = max(e.band.period for e in ex.logs)
    every, kinds = range(len(ex.logs)), _kinds(joint, period)
    (delay, by_delay), *filters = [_best(search, kind, every) for kind in kinds]
    best, left = min(filters, key=lambda found: found[1])
    if left > _CLEARLY * by_delay:
        best, left = delay, by_delay
    at_the_end = abs(best.late) > LATEST - period
    if at_the_end or abs(best.behind) < period / 2:
        return None
    rules, missing = search.rules, search.remaining_on([joint - 1])
    if left > min((1 - rules.whole) * missing, (1 - rules.explained[0]) * by_laws):
        return None
    kind = kinds[best.poles if best.filters else 0]
    each = [_best(search, kind, [i])[0].behind for i in every]
    alike = all(abs(own - best.behind) <= period + _ALIKE * abs(best.behind) for own in each)
    return best if alike else None


@dataclass(frozen=True)
class _Kind:
    """Ways that a torque may have come, over one number each; at (A,): the numbers that are tried first."""

    of: Callable[[float], OwnWay]
    at: np.ndarray


def _kinds(joint: int, period: float) -> list[_Kind]:
    """A delay, by half samples; low passes of one pole and of two, by the logarithm of the corner."""
    count = int(np.ceil(2 * LATEST / period))
    times = np.arange(-count, count + 1) * period / 2
    low, high = np.log([1 / (2 * np.pi * LATEST), _HIGHEST * 0.5 / period]).tolist()
    corners = np.linspace(low, high, _CORNERS)

    def low_pass(poles: int, logarithm: float) -> OwnWay:
        return OwnWay(joint, corner=float(np.exp(logarithm)), poles=poles)

    filters = [_Kind(partial(low_pass, poles), corners) for poles in (1, 2)]
    return [_Kind(lambda time: OwnWay(joint, late=time), times), *filters]


def _best(search: Search, kind: _Kind, numbers: Sequence[int]) -> tuple[OwnWay, float]:
    """The way of a kind that leaves least in some of the logs, and what it leaves."""

    def left(x: float) -> float:
        return _left(search, kind.of(x), numbers)

    step = float(kind.at[1] - kind.at[0])
    coarse = [left(x) for x in kind.at.tolist()]
    middle, least = float(kind.at[int(np.argmin(coarse))]), min(coarse)
    ends = (middle - step, middle + step)
    found: Any = minimize_scalar(left, bounds=ends, options={"xatol": _EXACT * step})
    return (kind.of(float(found.x)), float(found.fun)) if found.fun < least else (kind.of(middle), least)


def _left(search: Search, way: OwnWay, numbers: Sequence[int]) -> float:
    """What exceeds the floor on a joint's equation in some logs, its torque put right, its floor as well."""
    ex, base, row = search.examination, search.base, way.joint - 1
    heard, y = [], []
    for log, level, residual in zip(ex.logs, search.levels, base.residual, strict=True):
        torque = log.part.target[:, row]
        change = log.part.used(row, way.undone(torque, log.band.period) - torque)
        passed = np.abs(way.low_pass.passed(log.band.frequencies))
        heard.append(np.tile(passed, 2))
        y.append((residual[row] + log.band.transform(change[:, None])[:, 0] / level[row]) * heard[-1])
    own = [basis[row] for basis in base.basis]
    weighted = [A * h[:, None] for A, h in zip(own, heard, strict=True)]
    normal = np.eye(own[0].shape[1]) - sum(A.T @ A for A in own) + sum(A.T @ A for A in weighted)
    rest = sum(A.T @ x for A, x in zip(weighted, y, strict=True))
    others = -sum(A.T @ r[row] for A, r in zip(own, base.residual, strict=True))  # the base took all before
    part = np.linalg.lstsq(normal, rest + others, rcond=None)[0]
    left = [np.zeros_like(r) for r in base.residual]
    bands = [b if i in numbers else np.zeros_like(b) for i, b in enumerate(ex.bands)]
    for i in numbers:
        left[i][row] = y[i] - weighted[i] @ part
    return ex.excess(left, bands, [row])[0]
