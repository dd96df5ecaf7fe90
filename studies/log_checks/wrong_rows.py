"""Kinds of grossly wrong logs: what loggers and clocks do to rows."""

import numpy as np

from .changes import every, fastest, remade
from .wrong_logs import busy, kind, positions, torques


@kind("torques' clock 0.5 % fast")
def _(robot, frame):
    n = np.arange(len(frame), dtype=float)
    return every(frame, torques(robot), lambda x: np.interp(np.clip(1.005 * n, 0, n[-1]), n, x)).iloc[
        : int(0.99 * len(n))
    ]


@kind("torques through a slow filter of 60 ms")
def _(robot, frame):
    share = 1 - np.exp(-float(np.median(np.diff(frame["time"]))) / 0.06)

    def slow(x):
        for i in range(1, len(x)):
            x[i] = x[i - 1] + share * (x[i] - x[i - 1])
        return x

    return every(frame, torques(robot), slow)


@kind("a clock that wanders")
def _(robot, frame):
    t = frame["time"].to_numpy()
    T = float(np.median(np.diff(t)))
    return frame.assign(time=t + 3 * T * np.sin(2 * np.pi * (t - t[0]) / (t[-1] - t[0])))


@kind("rows in reverse order")
def _(robot, frame):
    return remade(frame, np.arange(len(frame))[::-1])


@kind("rows shuffled")
def _(robot, frame):
    return remade(frame, np.random.default_rng(1).permutation(len(frame)))


@kind("blocks of rows exchanged")
def _(robot, frame):
    n = len(frame)
    at = fastest(frame[busy(frame, positions(robot))].to_numpy(float))
    return remade(frame, np.r_[at:n, 0:at])


@kind("every tenth row twice")
def _(robot, frame):
    n = np.arange(len(frame))
    return remade(frame, np.sort(np.concatenate([n, n[::10]]))[: len(n)])


@kind("0.2 s of rows missing, time made even")
def _(robot, frame):
    n, at = np.arange(len(frame)), fastest(frame[busy(frame, positions(robot))].to_numpy(float))
    gap = max(5, round(0.2 / float(np.median(np.diff(frame["time"])))))
    return remade(frame, np.delete(n, slice(at, at + gap)))


@kind("2 % of the rows lost, time made even")
def _(robot, frame):
    rng = np.random.default_rng(2)
    return remade(frame, np.flatnonzero(rng.random(len(frame)) > 0.02))


@kind("torques of another part of the recording")
def _(robot, frame):
    return every(frame, torques(robot), lambda x: np.roll(x, len(x) // 3))


@kind("torques of white noise")
def _(robot, frame):
    rng = np.random.default_rng(3)
    return every(frame, torques(robot), lambda x: x.std() * rng.normal(size=len(x)))


@kind("positions held for 8 samples")
def _(robot, frame):
    return every(frame, positions(robot), lambda x: np.repeat(x[::8], 8)[: len(x)])


@kind("torques held for 15 samples")
def _(robot, frame):
    return every(frame, torques(robot), lambda x: np.repeat(x[::15], 15)[: len(x)])
