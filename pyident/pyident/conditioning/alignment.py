"""Positions and torques of a log brought together: on one clock, and without a low pass of the torques."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.logs.foreign import delayed, sooner
from pyident.logs.log import Log

HELD = 0.6  # of a sample: a loop that holds its torque until the next one logs it half of one early
LATEST = 0.05  # s: later is no matter of a drive, a filter or a clock
_HALF = 0.1  # of a sample: about half of one late
_LEAST = 0.03  # of a frequency, that is raised to its whole: less is rounding as well
_MATTERS = 0.2  # of the time constant of a low pass: a delay beside it
_ENOUGH = 0.1  # of a frequency that is judged


@dataclass(frozen=True)
class OwnWay:
    """What one joint's torque (from 1) alone went through: a delay [s], or a low pass [Hz] of some poles."""

    joint: int
    late: float = 0.0
    corner: float = np.inf
    poles: int = 1

    @property
    def filters(self) -> bool:
        """Whether it is a low pass."""
        return bool(np.isfinite(self.corner))

    @property
    def low_pass(self) -> "Alignment":
        return Alignment(corner=self.corner, poles=self.poles)

    @property
    def behind(self) -> float:
        """Time [s] by which what is slow comes late; early: below 0."""
        return self.late + self.low_pass.behind

    def undone(self, torque: np.ndarray, period: float) -> np.ndarray:
        """A torque (N,) as it was before."""
        if self.filters:
            torque = sharpened(torque[:, None], period, self.low_pass)[:, 0]
        return sooner(np.arange(len(torque)) * period, torque, self.late) if self.late else torque


@dataclass(frozen=True)
class Alignment:
    """What kept a log's positions and torques apart.

    late    time [s] by which all positions came late (early: below 0)
    corner  [Hz] of the low pass through which all torques came, infinite: of none
    poles   of it, as Butterworth's: one or two of a drive's
    twice   whether it went over them forwards and backwards, as over a record: it delays nothing then
    own     ways of single torques
    held    whether torques are held from their sample on, as equations of means take them exactly
    """

    late: float = 0.0
    corner: float = np.inf
    poles: int = 1
    twice: bool = False
    own: tuple[OwnWay, ...] = ()
    held: bool = False

    @staticmethod
    def by_clock(robot: Robot, late: float, period: float) -> "Alignment":
        """Of positions that are late [s], of a period [s]: by half a sample where a torque is held."""
        plain = robot.settings.processing.derivative is None
        if robot.flexible and plain and is_half(late, period):
            return Alignment(held=True)
        return Alignment(late)

    def taken(self, robot: Robot) -> Robot:
        """The robot whose equations take the torques so."""
        if not self.held:
            return robot
        return robot.with_settings(processing=replace(robot.settings.processing, derivative="hat"))

    @property
    def needed(self) -> bool:
        """Whether anything did."""
        return self != NOTHING

    def passed(self, frequencies: np.ndarray) -> np.ndarray:
        """(F,) complex: what the low pass lets through at frequencies (F,) [Hz], a thirtieth at least."""
        x = np.asarray(frequencies) / self.corner
        if self.twice:
            return np.maximum(1 / (1 + x ** (2 * self.poles)), _LEAST) + 0j
        passed = 1 / (1 + 1j * x) if self.poles == 1 else 1 / (1 + np.sqrt(2) * 1j * x - x**2)
        return passed * np.maximum(_LEAST / np.abs(passed), 1)

    @property
    def band(self) -> float:
        """[Hz] up to which enough is let through to be judged."""
        of_one_way = _ENOUGH if self.twice else _ENOUGH**2  # squared, of |H|
        return self.corner * (1 / of_one_way - 1) ** (0.5 / self.poles)

    def of(self, robot: Robot, log: Log) -> Log:
        """The log as it would have been without."""
        moved = earlier(robot, log, self.late)
        if np.isfinite(self.corner):
            names = list(robot.torques)
            before = sharpened(moved.signals(names), log.period, self)
            moved = replace(moved, frame=moved.frame.assign(**dict(zip(names, before.T, strict=True))))
        each = {robot.torques[way.joint - 1]: way for way in self.own}
        before = {name: way.undone(moved.signals([name])[:, 0], log.period) for name, way in each.items()}
        return replace(moved, frame=moved.frame.assign(**before)) if before else moved

    def of_all(self, robot: Robot, logs: Sequence[Log]) -> list[Log]:
        """Every log so."""
        return [self.of(robot, log) for log in logs]

    def then(self, further: "Alignment") -> "Alignment":
        """Both, one after the other; further: a delay, single torques' ways and that all are held alone."""
        ways = {way.joint: way for way in self.own}
        for way in further.own:
            known = ways.get(way.joint)
            ways[way.joint] = replace(known, late=known.late + way.late) if known else way
        held = self.held or further.held
        return replace(self, late=self.late + further.late, own=tuple(ways.values()), held=held)

    @property
    def delayed(self) -> bool:
        """Whether positions were late or early by what matters beside a low pass."""
        return abs(self.late) > _MATTERS / (2 * np.pi * self.corner)

    @property
    def delay(self) -> "Alignment":
        """What only delays as much, where torques are slow."""
        return Alignment(self.late - self.behind)

    @property
    def behind(self) -> float:
        """Time [s] by which the low pass delays what is slow."""
        if self.twice:
            return 0.0
        return (1.0 if self.poles == 1 else np.sqrt(2)) / (2 * np.pi * self.corner)


NOTHING = Alignment()


def is_half(time: float, period: float) -> bool:
    """Whether a time [s] is about half of a period [s], as far as a held torque is from its sample."""
    return abs(time / period - 0.5) < _HALF


def sharpened(values: np.ndarray, period: float, low_pass: Alignment) -> np.ndarray:
    """(N, K) signals before a low pass; noise that came behind it is raised."""
    line = np.linspace(values[0], values[-1], len(values))
    waves = values - line
    whole = np.concatenate([waves, waves[-2:0:-1]])  # goes on without a step at both ends
    passed = low_pass.passed(np.fft.rfftfreq(len(whole), period))
    before = np.fft.irfft(np.fft.rfft(whole, axis=0) / passed[:, None], len(whole), axis=0)[: len(line)]
    return before + line + (line[1] - line[0]) / period * low_pass.behind


def earlier(robot: Robot, log: Log, late: float) -> Log:
    """The log with its positions where they belong if they came late [s], straight on where it ends.

    Of a flexible robot its torques are moved to them: what twists of drives hold of encoders shows by their
    steps.
    """
    if late == 0.0:
        return log
    if robot.flexible:
        return replace(log, frame=delayed(log.frame, dict.fromkeys(robot.torques, -late)))
    lost = int(np.ceil(abs(late) / log.period))
    frame = delayed(log.frame, dict.fromkeys(robot.coordinates, late))
    values = frame[list(robot.coordinates)].to_numpy(copy=True)
    ends = values[::-1] if late > 0 else values  # the lost samples come first
    ends[:lost] = ends[lost] + np.arange(lost, 0, -1)[:, None] * (ends[lost] - ends[lost + 1])
    return replace(log, frame=frame.assign(**dict(zip(robot.coordinates, values.T, strict=True))))
