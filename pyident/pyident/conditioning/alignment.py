"""Positions and torques of a log brought together: on one clock, and without a low pass of the torques."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.logs.foreign import delayed
from pyident.logs.log import Log


@dataclass(frozen=True)
class Alignment:
    """What kept a log's positions and torques apart.

    late    time [s] by which all positions came late (early: below 0)
    corner  [Hz] of the low pass through which all torques came, infinite: of none
    poles   of it: one, or two of Butterworth's
    """

    late: float = 0.0
    corner: float = np.inf
    poles: int = 1

    @property
    def needed(self) -> bool:
        """Whether anything did."""
        return self != NOTHING

    def passed(self, frequencies: np.ndarray) -> np.ndarray:
        """(F,) complex: what the low pass lets through at frequencies (F,) [Hz]."""
        s = 1j * np.asarray(frequencies) / self.corner
        return 1 / (1 + s) if self.poles == 1 else 1 / (1 + np.sqrt(2) * s + s**2)

    def of(self, robot: Robot, log: Log) -> Log:
        """The log as it would have been without."""
        return self._sharpened(robot, earlier(robot, log, self.late))

    def of_all(self, robot: Robot, logs: Sequence[Log]) -> list[Log]:
        """Every log so."""
        return [self.of(robot, log) for log in logs]

    def _sharpened(self, robot: Robot, log: Log) -> Log:
        """With the torques before their low pass; noise that came behind it is raised."""
        if not np.isfinite(self.corner):
            return log
        names = list(robot.torques)
        values = log.signals(names)
        line = np.linspace(values[0], values[-1], len(values))
        waves = values - line
        whole = np.concatenate([waves, waves[-2:0:-1]])  # goes on without a step at both ends
        passed = self.passed(np.fft.rfftfreq(len(whole), log.period))
        before = np.fft.irfft(np.fft.rfft(whole, axis=0) / passed[:, None], len(whole), axis=0)[: len(line)]
        before += line + (line[1] - line[0]) / log.period * self.behind
        return replace(log, frame=log.frame.assign(**dict(zip(names, before.T, strict=True))))

    @property
    def behind(self) -> float:
        """Time [s] by which the low pass delays what is slow."""
        return (1.0 if self.poles == 1 else np.sqrt(2)) / (2 * np.pi * self.corner)


NOTHING = Alignment()


def earlier(robot: Robot, log: Log, late: float) -> Log:
    """The log with its positions where they belong if they came late [s], straight on where it ends."""
    if late == 0.0:
        return log
    lost = int(np.ceil(abs(late) / log.period))
    frame = delayed(log.frame, dict.fromkeys(robot.coordinates, late))
    values = frame[list(robot.coordinates)].to_numpy(copy=True)
    ends = values[::-1] if late > 0 else values  # the lost samples come first
    ends[:lost] = ends[lost] + np.arange(lost, 0, -1)[:, None] * (ends[lost] - ends[lost + 1])
    return replace(log, frame=frame.assign(**dict(zip(robot.coordinates, values.T, strict=True))))
