"""How high floors are: what replicas leave, of what the equations hold."""

import numpy as np

from pyident.diagnosis.base.residual_over_floor import Examination

_SLOW = 2.0  # Hz: noise below is seldom a sensor's


def floor_shares(ex: Examination) -> np.ndarray:
    """(n,) rms of the floor, of the torque or the stiffness' moment, per equation; NaN where that is none."""
    robot = ex.setting.robot
    level = np.mean(np.square(ex.floor.rms), axis=1) * ex.floor_energies / sum(e.y.shape[1] for e in ex.logs)
    out = np.zeros(len(robot.q))
    for row, coordinate in enumerate(robot.q):
        signals = []
        for log in ex.logs:
            part = log.part
            stiffness = coordinate.stiffness
            if stiffness is None:
                own = part.target[:, row]
            else:
                own = robot.parameters[stiffness] * part.motion.q[:, row]
            signals.append(np.square(log.band.transform(own * part.use[:, row])).mean())
        there = float(np.mean(signals))
        out[row] = np.sqrt(level[row] / there) if there > 0 else np.nan
    return out


def worth_little(ex: Examination) -> bool:
    """Whether replicas leave so much of most joints' torque that hardly anything could exceed it.

    Joints whose equations are never in use do not count.
    """
    motors = [row for row, c in enumerate(ex.setting.robot.q) if c.is_motor and ex.used[row]]
    if not motors:
        return False
    return bool(np.nanmedian(floor_shares(ex)[motors]) > ex.setting.rules.search.worthless)


def lowered_by(ex: Examination, row: int) -> str:
    """What may lower the floor of an equation, by the frequencies [Hz] at which most of it lies."""
    frequency, power = ex.floor.frequencies, np.square(ex.floor.rms[row])
    below = np.cumsum(power * np.gradient(frequency))
    half = float(frequency[int(np.searchsorted(below, below[-1] / 2))])
    if half < _SLOW:
        return (
            f"half of that is slower than {half:.2g} Hz, as of hands, wind, a hose, friction that wanders: "
            "let nothing touch the robot, or repeat the motion"
        )
    return "a slower motion, finer encoders or the controller in the robot file lower that"
