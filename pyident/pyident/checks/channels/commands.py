"""Commands that a servo does not follow: not recorded, exchanged, late, turned, of another unit.

A fit to positions rests on the commands alone. A servo that is driven by them moves after them, in their
direction and about as far; weight, friction and a soft loop change how far, never which of the two is first.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import motor_of, reference_of, switch_of
from flexmodels.robot import Robot
from pyident.checks.channels.quantisation import step_of
from pyident.checks.defect import Defect
from pyident.logs.log import Log
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.log_checks import LOG_CHECKS

_LONGEST = 0.5  # s between a command and its motion
_BESIDE = 2  # samples that a recorder may write a command late


def commands(robot: Robot, log: Log) -> Iterator[Defect]:
    """Defects of every joint that a servo drives and that moves."""
    if robot.servo is None:
        return
    driven = [_Driven.of(log, k) for k, _ in robot.numbered if reference_of(k) in log.names]
    farthest = max((float(np.ptp(one.e)) for one in driven), default=0.0)
    for one in driven:
        moves = np.ptp(one.e) > max(LOG_CHECKS.shaken * farthest, CHANNELS.standing * step_of(one.e))
        if one.switched_on and moves:
            yield from _of_joint(log, one)


@dataclass(frozen=True)
class _Driven:
    """Position and command of joint k, each (N,), and whether its servo was on for most of the log."""

    k: int
    e: np.ndarray
    r: np.ndarray
    switched_on: bool

    @staticmethod
    def of(log: Log, k: int) -> "_Driven":
        e, r = log.signals([motor_of(k), reference_of(k)]).T
        on = switch_of(k) not in log.names or bool(np.mean(log.frame[switch_of(k)] > 0.5) > 0.5)
        return _Driven(k, e, r, on)


def _of_joint(log: Log, one: _Driven) -> Iterator[Defect]:
    r, e = reference_of(one.k), motor_of(one.k)
    if np.ptp(one.r) <= 1e-9 * max(float(np.abs(one.r).max()), 1e-300):
        yield Defect("gross", "constant", r,
                     f"{log.source}: {r} is {one.r[0]:.6g} throughout while {e} moves "
                     f"over {np.ptp(one.e):.3g}; the commands were not recorded, or the servo was "
                      f"off: map its switch to {switch_of(one.k)}")  # fmt: skip
        return
    delays, correlation = _correlations(one, log.period)
    left = 1 - np.maximum(correlation, 0) ** 2  # of the position's variance, by a command so late
    turned = 1 - np.minimum(correlation, 0) ** 2
    after = delays >= -_BESIDE
    if turned[after].min() < LOG_CHECKS.far_better * left.min():
        yield Defect("gross", "sign", e, f"{log.source}: {e} moves against its command {r}; one of the two "
                      "has the wrong sign")  # fmt: skip
    elif (~after).any() and left[~after].min() < LOG_CHECKS.better * left[after].min():
        early = -delays[~after][np.argmin(left[~after])] * log.period
        sure = left[~after].min() < LOG_CHECKS.far_better * left[after].min()
        yield Defect("gross" if sure else "doubtful", "command", r, f"{log.source}: {e} moves {early:.2g} s "
                      f"before its command {r}; the two columns are exchanged, or the command was written "
                      "down late")  # fmt: skip
    elif left.min() < LOG_CHECKS.better:
        yield from _of_size(log, one, int(delays[np.argmin(left)]))


def _correlations(one: _Driven, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Delays [samples] and the correlation of the position with the command that much earlier."""
    most = max(min(round(_LONGEST / period), len(one.e) // 4), _BESIDE + 1)
    delays = np.arange(-most, most + 1)
    e = one.e[most:-most]
    found = np.zeros(len(delays))
    for i, d in enumerate(delays):
        r = one.r[most - d : len(one.r) - most - d]
        if np.ptp(r) > 0 and np.ptp(e) > 0:
            found[i] = np.corrcoef(e, r)[0, 1]
    return delays, found


def _of_size(log: Log, one: _Driven, delay: int) -> Iterator[Defect]:
    """A unit or a zero of its own. A soft servo under a weight goes a part of its way only, and never on."""
    first, last = max(delay, 0), len(one.e) + min(delay, 0)
    e, r = one.e[first:last], one.r[first - delay : last - delay]
    slope, _ = np.polyfit(r, e, 1)
    off, name, r_name = abs(float(np.median(e - r))), motor_of(one.k), reference_of(one.k)
    gross = not 1 / LOG_CHECKS.prior_gross < slope < LOG_CHECKS.prior_gross
    if gross or slope > LOG_CHECKS.torque_scale:
        yield Defect("gross" if gross else "doubtful", "unit", name,
                      f"{log.source}: {name} moves {slope:.3g} times as far as its command {r_name}; check "
                      "the units of both")  # fmt: skip
    elif off > LOG_CHECKS.torque_scale * max(float(np.ptp(e)), float(np.ptp(r))):
        yield Defect("doubtful", "zero", name, f"{log.source}: {name} is {off:.3g} away from its command "
                      f"{r_name}, more than either of them moves; check the zeros of both")  # fmt: skip
