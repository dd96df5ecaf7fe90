"""Defects of a log that a diagnosis would take for physics: one sentence each, with the cure.

Judged are the channels as they were recorded (saturated, stuck, coarse, with jumps) and the log as a whole
(clock, repeated or missing rows, torques that come late or with the wrong sign: see `alignment`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import butter, sosfiltfilt

from flexmodels.coordinate import joint_number
from flexmodels.robot import Robot
from pyident.checks.timing_and_signs import signs, timing
from pyident.conditioning.weak_form import DERIVATIVES
from pyident.logs.log import Log, require

_AT_LIMIT = 0.003  # share of the samples at the extreme value
_CROWDED = 6.0  # times the mean of the next bins: the crest of a sine gives 3.4
_BIN = 1e-3  # of a channel's range
_ODD = 25.0  # robust standard deviations of fourth differences: a jump
_BEYOND = 4.0  # times what all but one in a hundred of them are
_STUCK = 10  # samples
_BEHIND = 0.2  # of the way at the speed before: what a stuck channel jumps by when it is free again
_COARSE = 0.2  # of the acceleration's rms: what rounding may make of it
_SLOWEST = 20  # samples: the slowest update that is looked for
_ON_THE_BEAT = 0.98  # of the changes of a channel fall on every m-th sample
_DRIFT = 0.5  # samples


def integrity(robot: Robot, log: Log) -> list[str]:
    """One sentence per defect, none for a sound log. Raises LogError for what cannot be judged at all."""
    require(log, robot, 2 * _STUCK)
    coordinates = list(robot.coordinates)
    torques = list(robot.torques)
    found = list(_clock(log, [*coordinates, *torques]))
    sound = True
    for name in [*coordinates, *torques]:
        x = log.frame[name].to_numpy(float)
        if np.ptp(x) <= 1e-12 * max(float(np.abs(x).max()), 1e-300):
            found.append(f"{log.source}: {name} is {x[0]:.6g} throughout; the channel was not recorded")
            sound = False
            continue
        checks = [_stuck, _slow] if name in torques else [_stuck, _slow, _jumps, _coarse]
        for check in [*checks, _limit] if name in torques else checks:
            found += check(robot, log, name, x)
    if sound:
        found += [*timing(robot, log), *signs(robot, log)]
    return found


@dataclass(frozen=True)
class _Runs:
    """Where a channel repeats its value: first sample and number of samples of every run."""

    start: np.ndarray
    length: np.ndarray


def _runs(x: np.ndarray) -> _Runs:
    change = np.flatnonzero(np.diff(x)) + 1
    start = np.concatenate([[0], change])
    return _Runs(start, np.diff(np.append(start, len(x))))


def _clock(log: Log, channels: list[str]) -> Iterator[str]:
    time = log.frame["time"].to_numpy(float)
    even = np.linspace(time[0], time[-1], len(time))
    off = float(np.abs(time - even).max() / log.period)
    if off > _DRIFT:
        yield (
            f"{log.source}: the clock drifts, time is up to {off:.2g} samples away from a uniform one; "
            f"resample the log to a uniform period"
        )
    q = log.signals(channels)
    same = (np.diff(q, axis=0) == 0).all(axis=1)
    if len(channels) > 1 and (~same).mean() > 0.5:
        alone = np.flatnonzero(same[1:-1] & ~same[:-2] & ~same[2:]) + 1
        if len(alone) >= 3:
            yield (
                f"{log.source}: {len(alone)} rows repeat the row before in every channel, first at "
                f"{time[alone[0] + 1]:.4g} s; rows were recorded twice: remove them"
            )


def _limit(_: Robot, log: Log, name: str, x: np.ndarray) -> Iterator[str]:
    width = max(_BIN * float(np.ptp(x)), 1.01 * _step(x))
    for side, extreme in ((1.0, float(x.max())), (-1.0, float(x.min()))):
        depth = ((extreme - x) * side / width).astype(int)
        counts = np.bincount(depth[depth < 6], minlength=6)
        if counts[0] > max(_AT_LIMIT * len(x), 10) and counts[0] > _CROWDED * counts[1:].mean():
            yield (
                f"{log.source}: {name} stands at {extreme:.4g} in {100 * counts[0] / len(x):.2g} % of the "
                f"samples: it runs into a limit; repeat the motion with less torque"
            )


def _stuck(_: Robot, log: Log, name: str, x: np.ndarray) -> Iterator[str]:
    """A value that stays while it was moving fast just before, and then catches up; or stays to the end."""
    runs = _runs(x)
    step = _step(x)
    for at in np.flatnonzero(runs.length > _STUCK):
        start, length = int(runs.start[at]), int(runs.length[at])
        speed = np.abs(np.diff(x[max(start - 5, 0) : start]))
        after = x[start + length : start + length + 1]
        behind = len(after) == 0 or abs(after[0] - x[start]) > _BEHIND * length * speed.min(initial=np.inf)
        if len(speed) and speed.min() > 2 * step and behind and x[start] not in (x.max(), x.min()):
            time = log.frame["time"].to_numpy(float)
            yield (
                f"{log.source}: {name} is stuck from {time[start]:.4g} s for {length} samples; "
                f"cut the log there"
            )
            return


def _slow(_: Robot, log: Log, name: str, x: np.ndarray) -> Iterator[str]:
    """A channel that changes on every m-th sample only."""
    change = np.flatnonzero(np.diff(x)) + 1
    for m in range(_SLOWEST, 1, -1):
        beats = np.bincount(change % m, minlength=m)
        if beats.max() >= _ON_THE_BEAT * len(change) and len(change) > 0.3 * len(x) / m:
            yield (
                f"{log.source}: {name} changes only every {_ordinal(m)} sample; it was recorded at a lower "
                f"rate: keep every {_ordinal(m)} row"
            )
            return


def _jumps(robot: Robot, log: Log, name: str, x: np.ndarray) -> Iterator[str]:
    """Fourth differences that stick out: a jump stands in four of them, in a ratio of 1, -3, 3, -1."""
    fourth = np.abs(np.diff(x, 4))
    scale = 1.4826 * float(np.median(fourth))
    bound = max(_ODD * scale, _BEYOND * float(np.quantile(fourth, 0.99)), 16 * _step(x))
    high = np.flatnonzero(fourth > bound)
    if not len(high):
        return
    increment = np.diff(x)
    odd = increment - median_filter(increment, 7, mode="nearest")
    places = [p[0] + int(np.argmax(np.abs(odd[p[0] : p[-1] + 4]))) for p in _clusters(high)]
    sizes, time = np.abs(odd[places]), log.frame["time"].to_numpy(float)
    first = float(time[places[0] + 1])
    joint = robot.joints[joint_number(name) - 1]
    turns = sizes / (2 * np.pi)
    if joint.kind == "revolute" and sizes.min() > 3 and (np.abs(turns - np.round(turns)) < 0.02).all():
        yield f"{log.source}: {name} jumps by a turn at {first:.4g} s; unwrap it"
        return
    again = "" if len(places) == 1 else f" and at {len(places) - 1} other samples"
    yield (
        f"{log.source}: {name} jumps by {odd[places[0]]:.2g} at {first:.4g} s{again}; "
        f"a count was lost or rows are missing: cut the log there or mend the channel"
    )


def _clusters(at: np.ndarray) -> list[np.ndarray]:
    """Groups of neighbouring samples."""
    return np.split(at, np.flatnonzero(np.diff(at) > 4) + 1)


def _coarse(robot: Robot, log: Log, name: str, x: np.ndarray) -> Iterator[str]:
    """Rounding that makes a good part of the acceleration, without noise that would smooth it."""
    step = _step(x)
    if step == 0 or _noise(x) > step:
        return
    plan, T = robot.processing, log.period
    nyquist = 0.5 / T
    top = min(plan.cutoff or nyquist, 0.8 * nyquist / plan.decimate)
    share = (2 * np.pi) ** 2 * np.sqrt(top**5 / 5 / nyquist)  # rms acceleration per rms of white noise
    smooth = sosfiltfilt(np.asarray(butter(4, top / nyquist, output="sos")), x[:, None], axis=0)
    _, _, dde = DERIVATIVES["central"](np.asarray(smooth), T)
    acceleration = float(np.sqrt(np.mean(dde[20:-20] ** 2)))
    rounding = step / np.sqrt(12) * share
    if rounding > _COARSE * acceleration:
        yield (
            f"{log.source}: {name} comes in steps of {step:.3g}, which make some "
            f"{100 * min(rounding / max(acceleration, 1e-300), 1):.0f} % of its acceleration; "
            f"lower processing.cutoff in the robot file or record with a finer resolution"
        )


def _step(x: np.ndarray) -> float:
    """The step in which a channel is quantised, 0: none."""
    values = np.unique(x)
    if len(values) < 3:
        return 0.0
    gaps = np.diff(values)
    tiny = 1e-9 * float(np.abs(values).max())
    real = np.sort(gaps[gaps > tiny])
    if not len(real):
        return 0.0
    step = float(np.median(real[: max(3, len(real) // 100)]))
    off = np.abs(gaps / step - np.round(gaps / step))
    return step if np.mean(off < 0.05) > 0.95 and np.median(np.round(gaps / step)) < 50 else 0.0


def _noise(x: np.ndarray) -> float:
    """Standard deviation of a channel's white noise, from its sixth differences."""
    return float(1.4826 * np.median(np.abs(np.diff(x, 6))) / np.sqrt(924))


def _ordinal(m: int) -> str:
    return f"{m}{ {2: 'nd', 3: 'rd'}.get(m, 'th') }"
