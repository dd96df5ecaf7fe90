"""Kinds of grossly wrong logs: what encoders, drives and mappings do to channels."""

import numpy as np

from .changes import changed, every, fastest, remade
from .wrong_logs import busy, kind, positions, scaled, torques


@kind("angles wrapped at half a turn")
def _(robot, frame):
    name = busy(frame, positions(robot))
    if robot.joints[int(name[5]) - 1].kind != "revolute":
        return None

    def wrap(x):
        x = x - np.median(x) + np.pi
        return np.mod(x + np.pi, 2 * np.pi) - np.pi

    return changed(frame, name, wrap)


def _held(name, start, length):
    @kind(name)
    def _(robot, frame):
        channel = busy(frame, positions(robot))

        def stick(x):
            at = fastest(x) if start is None else int(start * len(x))
            stop = len(x) if length is None else at + length
            x[at:stop] = x[at]
            return x

        return changed(frame, channel, stick)


_held("a position stuck for 100 samples", None, 100)
_held("a position stuck to the end", 0.5, None)
_held("a position never recorded", 0.0, None)


@kind("all channels frozen for 150 samples")
def _(robot, frame):
    at = fastest(frame[busy(frame, positions(robot))].to_numpy(float))
    n = np.arange(len(frame))
    n[at : at + 150] = at
    return remade(frame, n)


@kind("a torque frozen for 1 s")
def _(robot, frame):
    def stick(x):
        at = len(x) // 3
        x[at : at + round(1 / float(np.median(np.diff(frame["time"]))))] = x[at]
        return x

    return changed(frame, busy(frame, torques(robot)), stick)


@kind("one torque zero throughout")
def _(robot, frame):
    return changed(frame, busy(frame, torques(robot)), lambda x: 0 * x)


@kind("all torques zero")
def _(robot, frame):
    return every(frame, torques(robot), lambda x: 0 * x)


@kind("torques clipped at half")
def _(robot, frame):
    return every(frame, torques(robot), lambda x: np.clip(x, 0.5 * x.min(), 0.5 * x.max()))


@kind("one torque clipped on one side")
def _(robot, frame):
    return changed(frame, busy(frame, torques(robot)), lambda x: np.minimum(x, np.quantile(x, 0.8)))


@kind("a position clipped")
def _(robot, frame):
    return changed(frame, busy(frame, positions(robot)), lambda x: np.clip(x, *np.quantile(x, [0.1, 0.9])))


@kind("positions in steps of 1 % of their range")
def _(robot, frame):
    return every(
        frame, positions(robot), lambda x: np.round(x / (0.01 * np.ptp(x) + 1e-300)) * 0.01 * np.ptp(x)
    )


@kind("spikes in a position")
def _(robot, frame):
    def spike(x):
        x[np.random.default_rng(4).integers(50, len(x) - 50, 8)] += 0.3 * np.ptp(x)
        return x

    return changed(frame, busy(frame, positions(robot)), spike)


@kind("spikes in a torque")
def _(robot, frame):
    def spike(x):
        x[np.random.default_rng(5).integers(50, len(x) - 50, 12)] += 5 * np.ptp(x)
        return x

    return changed(frame, busy(frame, torques(robot)), spike)


@kind("positions that drop to zero")
def _(robot, frame):
    lost = np.random.default_rng(6).random(len(frame)) < 0.01
    return every(frame, positions(robot), lambda x: np.where(lost, 0.0, x))


@kind("torques that drop to zero")
def _(robot, frame):
    lost = np.random.default_rng(7).random(len(frame)) < 0.01
    return every(frame, torques(robot), lambda x: np.where(lost, 0.0, x))


@kind("lost counts")
def _(robot, frame):
    def lose(x):
        x[len(x) // 2 :] += 0.05 * np.ptp(x)
        return x

    return changed(frame, busy(frame, positions(robot)), lose)


@kind("a position that overflows its counter")
def _(robot, frame):
    def overflow(x):
        width = 0.7 * np.ptp(x)
        return np.mod(x - x.min(), width) + x.min()

    return changed(frame, busy(frame, positions(robot)), overflow)


@kind("speeds in place of the positions")
def _(robot, frame):
    T = float(np.median(np.diff(frame["time"])))
    return every(frame, positions(robot), lambda x: np.gradient(x, T))


@kind("positions in place of the torques")
def _(robot, frame):
    return frame.assign(**{t: frame[e] for e, t in zip(positions(robot), torques(robot), strict=True)})


@kind("the column of time as a position")
def _(robot, frame):
    return frame.assign(**{"joint1.e": frame["time"] - frame["time"].iloc[0]})


@kind("position 1 in place of position 2")
def _(robot, frame):
    return frame.assign(**{"joint2.e": frame["joint1.e"]}) if len(robot.joints) > 1 else None


@kind("torque 1 in place of torque 2")
def _(robot, frame):
    return frame.assign(**{"joint2.tau": frame["joint1.tau"]}) if len(robot.joints) > 1 else None


@kind("a reference in place of a position")
def _(robot, frame):
    return frame.assign(**{"joint1.e": frame["joint1.r"]}) if "joint1.r" in frame else None


@kind("magnitudes of the torques")
def _(robot, frame):
    return every(frame, torques(robot), np.abs)


@kind("magnitudes of the positions")
def _(robot, frame):
    return every(frame, positions(robot), lambda x: np.abs(x - np.median(x)))


@kind("the zero of joint 2 off by 90 degrees")
def _(robot, frame):
    hinge = len(robot.joints) > 1 and robot.joints[1].kind == "revolute"
    return changed(frame, "joint2.e", lambda x: x + np.pi / 2) if hinge else None


@kind("positions buried in noise")
def _(robot, frame):
    rng = np.random.default_rng(8)
    return every(frame, positions(robot), lambda x: x + 0.05 * np.ptp(x) * rng.normal(size=len(x)))


def twists(robot):
    return [f"joint{k}.eps[1]" for k, joint in robot.numbered if joint.flexible]


@kind("twists negated")
def _(robot, frame):
    return scaled(frame, twists(robot), -1) if twists(robot) else None


@kind("twists in degrees")
def _(robot, frame):
    return scaled(frame, twists(robot), 180 / np.pi) if twists(robot) else None


@kind("twists in mrad")
def _(robot, frame):
    return scaled(frame, twists(robot), 1e3) if twists(robot) else None


@kind("link angles in place of the twists")
def _(robot, frame):
    whole = {name: frame[name] + frame[name.replace("eps[1]", "e")] for name in twists(robot)}
    return frame.assign(**whole) if whole else None


@kind("twists 1 and 2 exchanged")
def _(robot, frame):
    names = twists(robot)[:2]
    return frame.assign(**{names[0]: frame[names[1]], names[1]: frame[names[0]]}) if len(names) == 2 else None
