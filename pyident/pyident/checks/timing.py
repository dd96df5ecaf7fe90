"""Torques that belong to another instant than the motion beside them, or come from a clock that drifts.

What sticks holds its torque after it has stopped, as if this came late. So a delay must show where joints
keep moving as well. What else a balance leaves changes slowly, so that its samples say less than their
number: how sure a delay is, is seen from what a log tells without one or another of its stretches (Quenouille
1956; Künsch 1989).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from flexmodels.coordinate import torque_of
from pyident.checks.balances import Balances
from pyident.checks.defect import Defect, Severity
from pyident.regression.law_memory import filtered
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.log_checks import LOG_CHECKS

_FINE = 9  # half samples on either side that are looked at first
_NEAR = 6  # samples on either side in which a delay of all torques is sought
_SURE = 3.0  # standard deviations
_TRAVELS = np.array([1e-3, 3e-3, 1e-2, 3e-2])  # of the joint's way, over which friction turns round
_STRETCHES = 8  # of a log, each of which is left out once
_ON = 1.25  # times as much at three times the distance as at twice; 1.5 where a torque is of steps, 2.25 else
_ALL_OVER = 0.05  # of a torque's variance: so far away, what belonged together does no more
_LOST = 0.85  # of what a balance leaves: a delay of all torques leaves less, a ripple hardly
_TELLS = 1.0  # samples: of a joint whose delay is less certain, nothing is asked
_DRIFTS = (-32, -16, -8, -4, -2, 2, 4, 8, 16, 32)  # samples that a clock may gain over the log


def timing(of: Balances, source: str) -> Iterator[Defect]:
    """A defect per joint whose torque fits its motion far better earlier or later, one for all where they are
    late alike; or one for a drift.
    """
    late = {k: found for k in of.joints if (found := delay(of, k)) is not None}
    shared = _shared(of, late)
    if shared is not None:
        gross = any(_severity(of, found) == "gross" for found in late.values())
        yield _of_all(shared, source, "gross" if gross else "doubtful")
    else:
        yield from [_late(of, k, found, source) for k, found in late.items()] or _drift(of, source)


def energies(of: Balances, k: int, shifts: np.ndarray) -> np.ndarray:
    """(S,) what the balance of joint k leaves of its torque moved back by each of `shifts` (S,) [samples],
    over its variance."""
    torques = np.column_stack([of.samples.shifted(k, float(s)) for s in shifts])
    return of.left(k, torques) / max(of.variance(k), 1e-300)


@dataclass(frozen=True)
class Delay:
    """Samples by which a torque is late (early: below 0); shares of its variance left so and as it is."""

    shift: float
    left: float
    now: float


def delay(of: Balances, k: int) -> Delay | None:
    """Of joint k (from 0); None where moving its torque does not explain it far better."""
    most = min(EQUATIONS.most_shift, max(4, round(EQUATIONS.longest_shift / of.samples.period)))
    shifts = np.unique(np.concatenate([np.arange(-_FINE, _FINE + 1) / 2, np.arange(-most, most + 1)]))
    left = energies(of, k, shifts)
    best, now = int(np.argmin(left)), float(left[shifts == 0][0])
    shift = float(shifts[best])
    inside = 0 < best < len(shifts) - 1
    material = now - left[best] > LOG_CHECKS.delay_material**2
    if not inside or abs(shift) < LOG_CHECKS.delay or not material or left[best] > LOG_CHECKS.better * now:
        return None
    by_bristles = _left_by_bristles(of, k)
    if left[best] > LOG_CHECKS.better * by_bristles:
        return None
    told = _in_motion(of, k, shift)
    if told is None or not _grows(of, k, told):
        return None
    after = float(energies(of, k, np.array([told]))[0])
    return Delay(told, after, now) if after <= LOG_CHECKS.better * now else None


def _grows(of: Balances, k: int, shift: float) -> bool:
    """Whether what is left of joint k (from 0) goes on to grow as its torque is moved away from a delay.

    Of a ripple a balance of few samples takes more at one shift than at others, but leaves no more than all.
    """
    least, there, beyond = energies(of, k, shift * np.array([1.0, -1.0, -2.0]))
    return bool(beyond > _ALL_OVER or beyond - least > _ON * (there - least))


def _left_by_bristles(of: Balances, k: int) -> float:
    """What the balance of joint k (from 0) leaves over its torque's variance, where its dry friction turns
    round over a travel (Dahl 1968), which comes late, too: of the travel that leaves least."""
    from scipy.ndimage import uniform_filter1d  # much memory, for few logs

    signals, left = of.samples, []
    step, steps = np.diff(signals.q[:, k]), np.ones(len(signals.q) - 1)
    blurs = max(round(signals.blurred / (signals.period * float(np.median(np.diff(signals.at))))), 1)
    for travel in _TRAVELS * max(float(np.ptp(signals.q[:, k])), 1e-300):
        drive = step / travel
        bristles = filtered(-np.abs(drive), np.array([drive, drive]), steps, 0.0)
        left.append(of.left_beside(k, uniform_filter1d(bristles, blurs)[:, None]))  # as the torques are
    return min(left) / max(of.variance(k), 1e-300)


def _in_motion(of: Balances, k: int, shift: float) -> float | None:
    """What joint k (from 0) tells of such a shift where it keeps moving; None where that is nothing."""
    moving = of.in_motion
    width = round(abs(shift)) + _NEAR
    shifts = np.arange(-2 * width, 2 * width + 1) / 2
    told = _vertex(moving, k, shifts) if k in moving.joints else None
    if told is None or not _alike(told.shift, shift, told.std):
        return None
    std = max(told.std, _scatter(moving, lambda part: _shift(_vertex(part, k, shifts))))
    certain = abs(told.shift) > max(_SURE * std, LOG_CHECKS.delay + std)
    return told.shift if certain else None


def _scatter(of: Balances, told: Callable[[Balances], float | None]) -> float:
    """Standard deviation of what samples tell, by what they tell without each of a log's stretches; infinite
    where some tell nothing.
    """
    count = len(of.samples.at)
    place = np.arange(count) * _STRETCHES // count
    each = [told(of.within(place != stretch)) for stretch in range(_STRETCHES)]
    known = [x for x in each if x is not None]
    if len(known) < _STRETCHES:
        return float("inf")
    return float(np.sqrt((_STRETCHES - 1) * np.var(known)))


def _shift(told: "CommonDelay | None") -> float | None:
    return None if told is None else told.shift


def _alike(one: float, other: float, std: float) -> bool:
    """Whether two delays [samples] may be one."""
    return abs(one - other) <= LOG_CHECKS.delays_apart + _SURE * std


def _shared(of: Balances, late: Mapping[int, Delay]) -> "CommonDelay | None":
    """What makes all torques late alike, where some are late by themselves and no other fits worse so; None
    where one alone tells, or not every stretch of the log.
    """
    if not late or len(of.in_motion.joints) < 2:
        return None
    shift = _best_for_all(of.in_motion, float(np.median([found.shift for found in late.values()])))
    if shift is None:
        return None
    gained = [energies(of, k, np.array([0.0, shift])) for k in of.joints]
    better = sum(moved < LOG_CHECKS.better * now for now, moved in gained)
    if better < 2 or any(moved > now for now, moved in gained):
        return None
    std = _scatter(of.in_motion, lambda part: _best_for_all(part, shift))
    return CommonDelay(shift, std) if np.isfinite(std) else None


def _best_for_all(of: Balances, near: float) -> float | None:
    """The shift [samples] that suits all joints together, within two of a first guess; None: none there."""
    shifts = near + np.arange(-8, 9) / 4
    if not of.joints:
        return None
    each = np.array([energies(of, k, shifts) for k in of.joints])
    told = (each / np.maximum(each.min(axis=1, keepdims=True), 1e-300)).sum(axis=0)
    lowest = _lowest(shifts, told)
    return None if lowest is None else lowest.shift


def _severity(of: Balances, found: Delay) -> Severity:
    far = abs(found.shift) * of.samples.period >= LOG_CHECKS.delay_gross
    return "gross" if far and found.left < LOG_CHECKS.far_better * found.now else "doubtful"


def _late(of: Balances, k: int, found: Delay, source: str) -> Defect:
    time, share = abs(found.shift) * of.samples.period, found.left / found.now
    way, cause = "late", "a filter that only this torque passes"
    if found.shift < 0:
        way, cause = "early", "a slow current loop (effect torque_delay)"
    return Defect(
        _severity(of, found),
        "delay",
        torque_of(k + 1),
        f"{source}: {torque_of(k + 1)} is {abs(found.shift):.2g} samples ({1e3 * time:.2g} ms) {way}: moved "
        f"back it leaves {100 * share:.0f} % of the residual; give its column a delay in the mapping, or "
        f"look for {cause}",
    )


@dataclass(frozen=True)
class CommonDelay:
    """Samples by which all torques are late alike, and the standard deviation."""

    shift: float
    std: float


def common_delay(of: Balances) -> CommonDelay | None:
    """What a recorder does to every joint alike; None where joints differ, or one alone tells.

    The residual's energy over the shift has its minimum at the delay; its curvature there, over what is left,
    is the information on it.
    """
    told = _told(of)
    if len(told) < 2:
        return None
    pairs = combinations(told, 2)
    alike = all(_alike(a.shift, b.shift, float(np.hypot(a.std, b.std))) for a, b in pairs)
    return _together(told) if alike else None


def _told(of: Balances) -> list[CommonDelay]:
    """Of each joint that tells one."""
    shifts = np.arange(-2 * _NEAR, 2 * _NEAR + 1) / 2
    each = [_vertex(of, k, shifts) for k in of.joints]
    return [one for one in each if one is not None and one.std < _TELLS]


def _together(told: Sequence[CommonDelay]) -> CommonDelay | None:
    """Their mean, each by its weight."""
    if not told:
        return None
    weights = np.array([one.std**-2 for one in told])
    shift = float(weights @ [one.shift for one in told] / weights.sum())
    return CommonDelay(shift, float(weights.sum() ** -0.5))


def _vertex(of: Balances, k: int, shifts: np.ndarray) -> CommonDelay | None:
    """Of joint k (from 0) alone; None where its energy has no minimum among the shifts."""
    lowest = _lowest(shifts, energies(of, k, shifts))
    if lowest is None:
        return None
    count = float((of.samples.use[:, k] > 0).sum())
    least = max(lowest.left, LOG_CHECKS.torque_floor**2)
    return CommonDelay(lowest.shift, EQUATIONS.coloured * np.sqrt(least / (count * lowest.bend)))


@dataclass(frozen=True)
class _Lowest:
    """shift [samples] of the least on a parabola, its bend, and what is left at the shift next to it."""

    shift: float
    bend: float
    left: float


def _lowest(shifts: np.ndarray, left: np.ndarray) -> _Lowest | None:
    """Through the least of what shifts (S,) leave (S,) and its neighbours; None where it is at an end."""
    i = int(np.argmin(left))
    if not 0 < i < len(shifts) - 1:
        return None
    bend, slope, _ = np.polyfit(shifts[i - 1 : i + 2], left[i - 1 : i + 2], 2)
    return _Lowest(float(-slope / (2 * bend)), float(bend), float(left[i]))


def all_late(of: Balances, source: str) -> Iterator[Defect]:
    """A defect where every torque is at least about a sample late or early alike."""
    delay = common_delay(of.in_motion)
    if delay is None or abs(delay.shift) - _SURE * delay.std < LOG_CHECKS.common_delay:
        return
    std = max(delay.std, _scatter(of.in_motion, lambda part: _shift(_together(_told(part)))))
    each = (energies(of.in_motion, k, np.array([0.0, delay.shift])) for k in of.in_motion.joints)
    lost = any(moved < _LOST * now for now, moved in each)
    if lost and abs(delay.shift) - _SURE * std >= LOG_CHECKS.common_delay:
        yield _of_all(CommonDelay(delay.shift, std), source, "doubtful")


def _of_all(delay: CommonDelay, source: str, severity: Severity) -> Defect:
    way, cause, move = "late", "a recorder that reads before it steps writes them one sample late", "torques"
    if delay.shift < 0:
        way, cause, move = "early", "positions behind a filter or a bus make it look so", "positions"
    return Defect(
        severity,
        "delay",
        "",
        f"{source}: all torques are {abs(delay.shift):.2f} ± {max(delay.std, 0.01):.2f} samples {way}; "
        f"{cause}: move the columns of the {move}, or give them a delay in the mapping",
    )


def _drift(of: Balances, source: str) -> Iterator[Defect]:
    """All torques on a clock that runs faster or slower than the motion's."""
    along = np.linspace(-0.5, 0.5, len(of.samples.at))
    now, gain = 0.0, np.zeros(len(_DRIFTS))
    for k in of.joints:
        variance = max(of.variance(k), 1e-300)
        torques = np.column_stack([of.samples.shifted(k, d * along) for d in _DRIFTS])
        now += float(of.left(k, of.torque[:, k : k + 1])[0]) / variance
        gain += of.left(k, torques) / variance
    best = int(np.argmin(gain))
    material = now - gain[best] > len(of.joints) * LOG_CHECKS.delay_material**2
    if material and gain[best] < LOG_CHECKS.better * now:
        yield Defect(
            "doubtful",
            "drift",
            "",
            f"{source}: the torques' clock gains some {abs(_DRIFTS[best])} samples on the positions' over "
            f"the log; record both with one clock, or resample one of them",
        )
