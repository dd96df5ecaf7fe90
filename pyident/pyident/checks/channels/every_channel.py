"""Single channels of a log: not recorded, stuck, coarse, at a limit, with jumps or spikes, too slow."""

from collections.abc import Iterator

import numpy as np

from flexmodels.coordinate import joint_number, motor_of, reference_of, torque_of
from flexmodels.robot import Robot
from pyident.checks.channels.jumps import jumps, spikes
from pyident.checks.channels.quantisation import Runs, coarse, runs, step_of
from pyident.checks.defect import Defect, Severity
from pyident.logs.encoders import noise_of
from pyident.logs.log import Log
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.log_checks import LOG_CHECKS


def channels(robot: Robot, log: Log) -> Iterator[Defect]:
    """Defects of every position and torque that the log holds."""
    coordinates = [name for name in robot.coordinates if name in log.names]
    torques = [torque_of(k) for k, _ in robot.numbered if torque_of(k) in log.names]
    for name in [*coordinates, *torques]:
        x = log.frame[name].to_numpy(float)
        if np.ptp(x) <= 1e-12 * max(float(np.abs(x).max()), 1e-300):
            yield from _constant(log, name, x)
            continue
        found = runs(x)
        yield from _stuck(log, name, x, found)
        yield from _slow(log, name, found)
        if name in torques:
            yield from _limit(log, name, x)
            yield from spikes(log, name, x)
            yield from _unsigned(log, name, x)
        else:
            yield from _clipped(log, name, x, found)
            yield from jumps(robot, log, name, x)
            yield from coarse(robot, log, name, x)
            yield from _buried(log, name, x)


def _constant(log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """A channel of one value: an axis may stand still, but not with all else of its joint moving."""
    k = joint_number(name)
    others = [motor_of(k), reference_of(k), torque_of(k)]
    moving = [o for o in others if o != name and o in log.names and _moves(log, o)]
    if name == motor_of(k):
        moving = [o for o in moving if o == reference_of(k)]
    if moving:
        yield _defect("gross", "constant", log, name, f"is {x[0]:.6g} throughout while {moving[0]} moves; "
                      f"the channel was not recorded")  # fmt: skip


def _is_torque(name: str) -> bool:
    return name == torque_of(joint_number(name))


def _moves(log: Log, name: str) -> bool:
    """Whether a channel goes somewhere, beyond noise about one value."""
    x = log.frame[name].to_numpy(float)
    return bool(np.ptp(x) > 0 and np.sqrt(np.mean(np.diff(x) ** 2)) < np.std(x))


def _stuck(log: Log, name: str, x: np.ndarray, of: Runs) -> Iterator[Defect]:
    """A value that stays while its channel was moving, and then catches up in one step.

    An axis that slows down, stands or starts smoothly stays longer and longer on each value of its encoder,
    so the runs beside a long one are long too, and it goes on with a step like all others. A torque in steps
    that often keeps one does so at constant speeds, which nothing tells from a sensor that hangs.
    """
    time, torque = log.frame["time"].to_numpy(float), _is_torque(name)
    long = np.flatnonzero(of.length > LOG_CHECKS.gap_rows)
    steps = np.abs(np.diff(x))
    ends = (of.start + of.length - 1)[long]
    usual = float(np.delete(steps, ends[ends < len(steps)]).max(initial=0.0))
    count, stuck = step_of(x) if len(long) else 0.0, []
    for at in long:
        start, length = int(of.start[at]), int(of.length[at])
        many = CHANNELS.neighbours
        before, after = of.length[max(at - many, 0) : at], of.length[at + 1 : at + 1 + many]
        if len(before) < 3 or length < LOG_CHECKS.freeze * before.max():
            continue
        if torque:
            hangs = _frozen(log, name, start, length, after)
        elif start + length >= len(x):
            hangs = length > 3 * LOG_CHECKS.gap_rows and _sudden(log, steps[:start][::-1], count)
        else:
            hangs = steps[start + length - 1] > LOG_CHECKS.catch_up * usual
        if hangs:
            stuck.append((start, length))
    if stuck:
        start, length = stuck[0]
        repeats = np.mean(np.delete(steps, slice(start, start + length)) == 0)
        natural = torque and count > 0 and repeats > CHANNELS.repeats
        severity: Severity = "doubtful" if natural else "gross"
        where = f"from {time[start]:.13g} s for {length} samples"
        said = (
            f"keeps one value {where}, in steps of {count:.3g}; if its sensor hung, cut the log there"
            if natural
            else f"is stuck {where}; cut the log there"
        )
        yield _defect(severity, "stuck", log, name, said)


def _frozen(log: Log, name: str, start: int, length: int, after: np.ndarray) -> bool:
    """A torque that changes from sample to sample keeps one value while its joint moves on.

    A torque in steps that goes on with the next one was never further than a step from what it kept; where
    its joint turns round or comes to rest, friction makes many steps at once.
    """
    e = motor_of(joint_number(name))
    if e not in log.names or len(after) < 3 or length < LOG_CHECKS.freeze * after.max():
        return False
    tau, x = log.frame[name].to_numpy(float), log.frame[e].to_numpy(float)
    at_end = min(tau.max() - tau[start], tau[start] - tau.min()) < 0.01 * np.ptp(tau)  # a limit, not stuck
    long = length > max(2 * LOG_CHECKS.gap_rows, CHANNELS.frozen / log.period)
    end, step = start + length, step_of(tau)
    if step and (abs(tau[end] - tau[start]) < 1.5 * step or _turns(x[end - 3 : end + 3])):
        return False
    return long and not at_end and np.ptp(x[start : start + length]) > CHANNELS.way * np.ptp(x)


def _turns(x: np.ndarray) -> bool:
    """Whether a joint that moved does not go on in its direction."""
    ways = np.diff(x)
    return bool(ways[0] * ways[-1] <= 0.1 * ways[0] ** 2)


def _clipped(log: Log, name: str, x: np.ndarray, of: Runs) -> Iterator[Defect]:
    """A position that runs into its largest or smallest value at full speed, and leaves it so."""
    samples, steps, long = 0, np.abs(np.diff(x)), of.length > LOG_CHECKS.gap_rows
    count = step_of(x) if long.any() else 0.0
    for extreme in (x.max(), x.min()):
        for at in np.flatnonzero((x[of.start] == extreme) & long):
            first, last = int(of.start[at]), int(of.start[at] + of.length[at] - 1)
            if all(_sudden(log, way, count) for way in (steps[:first][::-1], steps[last:])):
                samples += int(of.length[at])
    if samples > LOG_CHECKS.at_limit * len(x):
        yield _defect("gross", "limit", log, name, f"stands at its largest or smallest value in "
                      f"{100 * samples / len(x):.2g} % of the samples and gets there at full speed: the "
                      f"channel is clipped; widen its range")  # fmt: skip


def _sudden(log: Log, steps: np.ndarray, count: float) -> bool:
    """Steps (sizes) from a stop outwards: whether a joint came to it, or left it, faster than any motor can.

    The second (the first is cut short) is as long as those beyond, in a log that resolves a braking; a single
    count of the encoder is no speed.
    """
    if log.period > CHANNELS.braking or len(steps) < 6:
        return False
    second, beyond = float(steps[1]), float(steps[2:6].mean())
    return second > max(0.8 * beyond, 1.5 * count) and second > CHANNELS.at_speed * float(
        np.sqrt(np.mean(steps**2))
    )


def _buried(log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """A motor's position that is noise for the most part wherever differences are taken: no encoder's."""
    share = noise_of(x) / max(float(np.ptp(x)), 1e-300)
    if name == motor_of(joint_number(name)) and _moves(log, name) and share > CHANNELS.noisy:
        yield _defect("doubtful", "noise", log, name, f"has noise of {100 * share:.2g} % of its range, more "
                      f"than any encoder; check the channel and its plug")  # fmt: skip


def _limit(log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """A torque that piles up at its extreme."""
    width, step = LOG_CHECKS.limit_bin * float(np.ptp(x)), step_of(x)
    if step:  # as many steps in every bin, whole ones
        width = step * np.ceil(width / step)
    for side, extreme in ((1.0, float(x.max())), (-1.0, float(x.min()))):
        depth = (((extreme - x) * side + step / 2) / width).astype(int)
        counts = np.bincount(depth[depth < 6], minlength=6)
        share = counts[0] / len(x)
        resting = extreme == 0 or _longest(depth == 0) > 0.5 * counts[0] > 0.25 * len(x)
        least = max(LOG_CHECKS.at_limit, 10 / len(x))
        if share > least and counts[0] > LOG_CHECKS.crowded * counts[1:].mean() and not resting:
            severity: Severity = "gross" if share > LOG_CHECKS.limit_gross else "doubtful"
            yield _defect(severity, "limit", log, name, f"stands at {extreme:.4g} in {100 * share:.2g} % of "
                          "the samples: it runs into a limit; repeat it with less torque")  # fmt: skip


def _longest(true: np.ndarray) -> int:
    found = runs(true.astype(int))
    return int(max((n for s, n in zip(found.start, found.length, strict=True) if true[s]), default=0))


def _unsigned(log: Log, name: str, x: np.ndarray) -> Iterator[Defect]:
    """A torque that bounces off zero again and again: its magnitude. What carries a weight turns before."""
    if x.min() < 0 < x.max():
        return
    size, largest = np.abs(x), float(np.abs(x).max())
    clear = np.flatnonzero((size < 0.02 * largest) | (size > 0.2 * largest))
    away = size[clear] > 0.2 * largest  # noise about zero touches it once
    stays = np.split(clear, np.flatnonzero(np.diff(away)) + 1)
    lowest = [stay[np.argmin(size[stay])] for stay in stays if size[stay[0]] < 0.02 * largest]
    steps = np.abs(np.diff(x))
    touches = sum(size[i] <= steps[max(i - 2, 0) : i + 2].max(initial=0.0) for i in lowest)
    if touches >= 4:
        yield _defect("doubtful", "unsigned", log, name, f"comes to zero {touches} times and never changes "
                      f"its sign; it looks like a magnitude: record the signed torque")  # fmt: skip


def _slow(log: Log, name: str, of: Runs) -> Iterator[Defect]:
    """A channel that changes on every m-th sample only."""
    change = of.start[1:]
    for m in range(LOG_CHECKS.slowest_update, 1, -1):
        beats = np.bincount(change % m, minlength=m)
        if beats.max() >= LOG_CHECKS.on_the_beat * len(change) and len(change) > 0.3 * len(log) / m:
            nth = f"{m}{ {2: 'nd', 3: 'rd'}.get(m, 'th') }"
            yield _defect("gross" if m > 3 and not _is_torque(name) else "doubtful", "rate", log, name,
                          f"changes only every {nth} sample; it was recorded at a lower rate: keep every "
                          f"{nth} "
                          f"row")  # fmt: skip
            return


def _defect(severity: Severity, kind: str, log: Log, name: str, text: str) -> Defect:
    return Defect(severity, kind, name, f"{log.source}: {name} {text}")
