"""The log as a whole: its clock, its rows, channels that are one another, speeds that no joint has."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from flexmodels.coordinate import motor_of, reference_of, torque_of
from flexmodels.robot import Robot
from pyident.checks.defect import Defect
from pyident.logs.log import Log
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.log_checks import LOG_CHECKS


def whole_log(robot: Robot, log: Log) -> Iterator[Defect]:
    """Defects that no single channel shows."""
    logged = [n for n in [*robot.coordinates, *(torque_of(k) for k, _ in robot.numbered)] if n in log.names]
    yield from _surplus(robot, log)
    yield from _period(robot, log)
    yield from _clock(log)
    yield from _repeated_rows(log, logged)
    yield from _shuffled(robot, log)
    yield from _same(robot, log, logged)
    yield from _speeds(robot, log)


def _surplus(robot: Robot, log: Log) -> Iterator[Defect]:
    """Joints beyond the robot's."""
    here, further = len(robot.joints), 0
    while motor_of(here + further + 1) in log.names:
        further += 1
    if further:
        joints = f"{here} joint" if here == 1 else f"{here} joints"
        yield Defect("doubtful", "joints", motor_of(here + 1),
                     f"{log.source}: robot {robot.name} has {joints}, and the log {here + further}; what "
                     "moves beyond is left out, with what it does to the others: is it this robot's "
                     "log?")  # fmt: skip


def _period(robot: Robot, log: Log) -> Iterator[Defect]:
    T = log.period
    control = robot.controller.period if robot.controller else None
    off = 1.0 if control is None else max(T / control, control / T)
    gross = LOG_CHECKS.impossible_period < T or off > LOG_CHECKS.rate_ratio
    if gross or not LOG_CHECKS.shortest_period <= T <= LOG_CHECKS.longest_period:
        yield Defect("gross" if gross else "doubtful", "time", "time",
                     f"{log.source}: a sample every {T:.4g} s is not how a robot is recorded; check the "
                     "unit of "
                     f"time (s), for example ms or µs")  # fmt: skip


def _clock(log: Log) -> Iterator[Defect]:
    time = log.frame["time"].to_numpy(float)
    even = np.linspace(time[0], time[-1], len(time))
    off = float(np.abs(time - even).max() / log.period)
    if off > LOG_CHECKS.drift:
        yield Defect("doubtful", "clock", "time",
                     f"{log.source}: the clock drifts, time is up to {off:.2g} samples away from a uniform "
                     "one; "
                     f"resample the log to a uniform period")  # fmt: skip


def _repeated_rows(log: Log, logged: list[str]) -> Iterator[Defect]:
    time, q = log.frame["time"].to_numpy(float), log.signals(logged)
    changed = (np.diff(q, axis=0) != 0).mean(axis=1)  # share of the channels
    if len(logged) < 2 or np.median(changed) < CHANNELS.busy:
        return
    around = np.minimum(changed[:-2], changed[2:])
    alone = np.flatnonzero((changed[1:-1] == 0) & (around > CHANNELS.busy)) + 1
    if len(alone) >= 3:
        yield Defect("gross" if len(alone) > 0.02 * len(q) else "doubtful", "rows", "",
                     f"{log.source}: {len(alone)} rows repeat the row before in every channel, first at "
                     f"{time[alone[0] + 1]:.13g} s; unless all axes stood, rows were recorded twice: remove "
                     "them")  # fmt: skip


def _shuffled(robot: Robot, log: Log) -> Iterator[Defect]:
    """Every position steps about as far from row to row as it goes at all."""
    e = log.signals([motor_of(k) for k, _ in robot.numbered])
    spread = e.std(axis=0)
    rough = [
        np.sqrt(np.mean(np.diff(x) ** 2)) > LOG_CHECKS.shuffled * s for x, s in zip(e.T, spread, strict=True)
    ]
    if all(rough) and spread.any():
        yield Defect("gross", "rows", "", f"{log.source}: positions leap from row to row as far as they go "
                                          "at all; "
                     f"rows are out of order, or the columns hold something else")  # fmt: skip


def _same(robot: Robot, log: Log, logged: list[str]) -> Iterator[Defect]:
    """Two channels that are one: a column was mapped twice."""
    time = log.frame["time"].to_numpy(float)
    moving = {n: x for n in logged if np.ptp(x := log.frame[n].to_numpy(float)) > 0}
    pairs = list(combinations(moving, 2))
    for a, b in pairs:
        x, y = moving[a], moving[b]
        if np.abs(x - y).max() <= LOG_CHECKS.same * np.abs(x).max():
            yield Defect("gross", "same", a, f"{log.source}: {a} and {b} are the same numbers; a column was "
                                             "mapped "
                         f"twice")  # fmt: skip
    for name, x in moving.items():
        line = np.polyval(np.polyfit(time, x, 1), time)
        if np.abs(x - line).max() <= 1e-6 * np.ptp(x):
            yield Defect("gross", "same", name, f"{log.source}: {name} grows evenly with time; it looks "
                                                "like the "
                         f"column of time")  # fmt: skip
    for k, _ in robot.numbered:
        e, r = motor_of(k), reference_of(k)
        if e in moving and r in log.names:
            wanted = log.frame[r].to_numpy(float)
            if np.abs(moving[e] - wanted).max() <= LOG_CHECKS.same * np.abs(moving[e]).max():
                yield Defect("gross", "same", e, f"{log.source}: {e} and {r} are the same numbers; the "
                                                 "reference "
                             f"stands where the measured position should")  # fmt: skip


def _speeds(robot: Robot, log: Log) -> Iterator[Defect]:
    for k, joint in robot.numbered:
        x = log.frame[motor_of(k)].to_numpy(float)
        speed = float(np.quantile(np.abs(np.diff(x)), 0.9) / log.period)
        unit = "rad/s" if joint.kind == "revolute" else "m/s"
        limits = joint.limits
        if speed > LOG_CHECKS.fastest:
            severity = "gross" if speed > LOG_CHECKS.impossible_speed else "doubtful"
            yield Defect(severity, "unit", motor_of(k),
                         f"{log.source}: {motor_of(k)} moves at {speed:.3g} {unit}; check its unit (rad, not "
                         "degrees; "
                         f"m, not mm), the gear ratio, and the unit of time")  # fmt: skip
        elif limits is not None and limits.position is not None:
            width = limits.position[1] - limits.position[0]
            if width > 0 and np.ptp(x) > LOG_CHECKS.beyond_limits * width:
                yield Defect("gross" if np.ptp(x) > 10 * width else "doubtful", "unit", motor_of(k),
                             f"{log.source}: {motor_of(k)} goes over {np.ptp(x):.3g}, the robot file's "
                             f"limits allow {width:.3g}; check its unit (rad or m)")  # fmt: skip
