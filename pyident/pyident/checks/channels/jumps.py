"""Positions that jump and torques that stick out for a sample: lost counts, lost rows, wrapped angles."""

from collections.abc import Iterator, Sequence

import numpy as np

from flexmodels.coordinate import is_motor, joint_number, motor_of, reference_of
from flexmodels.robot import Robot
from pyident.checks.channels.quantisation import step_of
from pyident.checks.defect import Defect
from pyident.logs.encoders import noise_of
from pyident.logs.log import Log
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.log_checks import LOG_CHECKS

_REACH = 4  # samples of a fourth difference


def jumps(robot: Robot, log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """Fourth differences of x (N,) that stick out: a jump stands in four, in a ratio of 1, -3, 3, -1.

    Where a motor sticks, or breaks away, its acceleration jumps, and hinges jump and ring with it. Where a
    reference has a kink, its joint follows.
    """
    joint = robot.joints[joint_number(name) - 1]
    turns = np.diff(x) / (2 * np.pi)
    wrapped = np.flatnonzero((np.abs(turns) > 0.9) & (np.abs(turns) < 1.1))
    if joint.kind == "revolute" and len(wrapped) and np.median(np.abs(turns)) < CHANNELS.whole_turns:
        yield _turn(log, name, int(wrapped[0]))
        return
    high = _odd_places(x)
    if len(high) and not is_motor(name):
        motors = [c for c in robot.coordinates if is_motor(c) and c in log.frame]
        high = high[~_near([_odd_places(log.frame[c].to_numpy(float)) for c in motors], high)]
    if len(high):
        high = high[~_near([_kinks(log, name)], high)]
    if not len(high):
        return
    increment = np.diff(x)
    odd = increment - _smooth(increment)
    places = [p[0] + int(np.argmax(np.abs(odd[p[0] : p[-1] + 4]))) for p in _clusters(high)]
    places = [p for p in places if not _stops_or_starts(increment, p, step_of(x))]
    if not places:
        return
    sizes, time = np.abs(odd[places]), log.frame["time"].to_numpy(float)
    largest = places[int(np.argmax(sizes))]
    others = np.abs(np.delete(increment, places))
    if sizes.max() < CHANNELS.tiny_jump * np.ptp(x):
        return
    if log.period > CHANNELS.braking and sizes.max() < 2 * others.max():
        return
    again = "" if len(places) == 1 else f" and at {len(places) - 1} other samples"
    gross = sizes.max() > CHANNELS.large_jump * np.ptp(x) or len(places) > max(CHANNELS.many * len(x), 3)
    yield Defect("gross" if gross else "doubtful", "jump", name,
                 f"{log.source}: {name} jumps by {odd[largest]:.2g} at {time[largest + 1]:.13g} s{again}; a "
                 f"count was lost or rows are missing: cut the log there or repair the channel")  # fmt: skip


def _stops_or_starts(increment: np.ndarray, at: int, step: float) -> bool:
    """Whether a motion of steps (N,) ends or begins at one of them, no larger than those on the moving side.

    step   of the encoder
    """
    sides = [np.abs(increment[max(at - _REACH, 0) : at]), np.abs(increment[at + 1 : at + 1 + _REACH])]
    if not all(len(side) for side in sides):
        return False
    rest, moving = sorted(float(side.max()) for side in sides)
    stands = rest <= max(2 * step, CHANNELS.stopped * moving)
    return stands and abs(float(increment[at])) <= moving


def _odd_places(x: np.ndarray) -> np.ndarray:
    """Where fourth differences of x (N,) stick out.

    Of many jumps none is far beyond the 99th percentile: they count where each stands by itself.
    """
    fourth, least = np.abs(np.diff(x, 4)), CHANNELS.encoder_steps * step_of(x)
    usual = LOG_CHECKS.odd * _usual(fourth, np.abs(_smooth(np.diff(x)))[1:-2])
    most = np.where(_by_itself(x), 0.0, LOG_CHECKS.beyond * float(np.quantile(fourth, 0.99)))
    bent = CHANNELS.bent_ends
    return bent + np.flatnonzero((fourth > np.maximum(usual, np.maximum(most, least)))[bent:-bent])


def _by_itself(x: np.ndarray) -> np.ndarray:
    """(N - 4,) whether a step of x (N,), there and back or not, is far larger than those around it.

    Where an axis mostly stands each count of its encoder is.
    """
    size = np.abs(np.diff(x))
    if np.median(size) == 0:
        return np.zeros(len(x) - 4, bool)
    padded = np.pad(size, 3, mode="edge")
    around = np.maximum.reduce([padded[at : at + len(size)] for at in (0, 1, 5, 6)])
    alone = size > np.maximum(CHANNELS.alone * around, CHANNELS.large_jump * np.ptp(x))
    return alone[1:-2] | alone[2:-1]


def _kinks(log: Log, name: str) -> np.ndarray:
    """Where the reference of the joint of a channel jumps or bends, which its controller answers."""
    reference = reference_of(joint_number(name))
    if reference not in log.frame:
        return np.zeros(0, int)
    return _odd_places(log.frame[reference].to_numpy(float))


def _usual(fourth: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """(M,) deviations of fourth differences (M,) at speeds (M,), in steps per sample.

    A sample that was not taken when its stamp says is off by the speed times the time between: by what half
    of the way (not of the time) has more than half of the samples, the speed's share is measured.
    """
    scale, on_the_way = (1.4826 * _median(fourth, weight) for weight in (np.ones(len(fourth)), speed))
    jitter = np.sqrt(max(on_the_way**2 - scale**2, 0.0)) / max(_median(speed, speed), 1e-300)
    return np.hypot(scale, jitter * speed)


def _median(x: np.ndarray, weight: np.ndarray) -> float:
    """Of x (N,), each counted by its weight (N,)."""
    order = np.argsort(x)
    counted = np.cumsum(weight[order])
    return float(x[order[np.searchsorted(counted, counted[-1] / 2)]])


def _smooth(increment: np.ndarray) -> np.ndarray:
    """Steps (N,) from sample to sample without those that stick out."""
    from scipy.ndimage import median_filter  # here and below: much memory, for few logs

    return median_filter(increment, 7, mode="nearest")


def _near(events: Sequence[np.ndarray], places: np.ndarray) -> np.ndarray:
    """Whether each of some places comes at an event or soon after one."""
    after = places[:, None] - np.concatenate(events)[None, :]
    return np.any((after >= -_REACH) & (after <= CHANNELS.ringing), axis=1)


def _turn(log: Log, name: str, at: int) -> Defect:
    time = log.frame["time"].to_numpy(float)
    return Defect("gross", "wrapped", name,
                  f"{log.source}: {name} jumps by a turn at {time[at + 1]:.13g} s; unwrap it")  # fmt: skip


def spikes(log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """Single samples of a torque x (N,) far off those beside them, beyond its noise and its own steps.

    What lies beside a larger step of the torque is none: friction of a second motor may jump anywhere.
    Where the joint reverses, stops or starts, its dry friction jumps, and may jump twice: only what is larger
    than the range of all the rest is a spike there.
    """
    from scipy.ndimage import median_filter

    yield from _dropouts(log, name, x)
    odd = np.abs(x - median_filter(x, 5, mode="nearest"))
    odd[x == 0] = 0
    usual = max(float(np.quantile(odd, 0.98)), noise_of(x), 2 * step_of(x))
    beside, step = median_filter(x, 3, mode="nearest"), np.zeros(len(x))
    step[2:-2] = np.abs(beside[4:] - beside[:-4])
    alone = np.flatnonzero(odd > np.maximum(max(LOG_CHECKS.spike * usual, 0.05 * np.std(x)), step))
    if len(alone):
        alone = alone[~_near([_kinks(log, name)], alone)]
    if not len(alone) or len(alone) > 0.02 * len(x):
        return
    largest = CHANNELS.wide_spike * np.ptp(np.delete(x, alone))
    wide = bool(odd[alone].max() > largest)
    alone = alone[(odd[alone] > largest) | ~_turns(log, name)[alone]]
    if not wide and len(alone) < CHANNELS.few:
        return
    time = log.frame["time"].to_numpy(float)
    gross = len(alone) > max(CHANNELS.many * len(x), 3) or wide
    yield Defect("gross" if gross else "doubtful", "spike", name,
                 f"{log.source}: {name} sticks out by {odd[alone].max():.3g} for single samples, "
                 f"{len(alone)} times, first at "
                 f"{time[alone[0]]:.13g} s; repair the channel or cut the log there")  # fmt: skip


def _turns(log: Log, name: str) -> np.ndarray:
    """(N,) whether the joint of the torque `name` reverses, stops or starts about then."""
    motor = motor_of(joint_number(name))
    if motor not in log.names:
        return np.zeros(len(log), bool)
    angle, reach = log.frame[motor].to_numpy(float), CHANNELS.turning
    padded = np.pad(angle, reach, mode="edge")
    went = padded[2 * reach :] - padded[: -2 * reach]
    still = max(CHANNELS.still * noise_of(angle), step_of(angle))
    way = np.where(np.abs(went) <= still, 0.0, np.sign(went))
    turns = np.diff(way, prepend=way[:1]) != 0
    return np.convolve(turns, np.ones(2 * reach + 1), "same") > 0


def _dropouts(log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """Exact zeros between values of one sign that are far from it, farther than other samples from theirs."""
    before, here, after = x[:-2], x[1:-1], x[2:]
    odd, beside = np.abs(here - (before + after) / 2), (before == 0) | (here == 0) | (after == 0)
    usual = float(np.quantile(odd[~beside], 0.99)) if not beside.all() else 0.0
    far = np.minimum(np.abs(before), np.abs(after)) > max(0.05 * np.std(x), 3 * step_of(x), usual)
    lost = np.flatnonzero((here == 0) & far & (before * after > 0)) + 1
    if len(lost) >= CHANNELS.few:
        time = log.frame["time"].to_numpy(float)
        yield Defect("gross" if len(lost) > CHANNELS.many * len(x) else "doubtful", "spike", name,
                     f"{log.source}: {name} drops to zero for single samples, {len(lost)} times, first at "
                     f"{time[lost[0]]:.13g} s; values were lost: repair the channel")  # fmt: skip


def _clusters(at: np.ndarray) -> list[np.ndarray]:
    """Groups of neighbouring samples."""
    return np.split(at, np.flatnonzero(np.diff(at) > 4) + 1)
