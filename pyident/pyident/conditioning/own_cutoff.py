"""A low pass for joints that bend, where encoders are coarse and neither a cutoff nor a controller is known.

The equation of a link behind a spring has nothing on its right side: J (q̈ + ε̈) + d ε̇ + k ε = 0. Where
differences raise the noise of encoders above the accelerations, J = d = k = 0 fits it best.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.smooth_motion import SHORTEST, all_reached, all_smooth, channel_noise
from pyident.logs.log import Log

_BLURS = 0.2  # noise of an acceleration over the acceleration, from which it matters
_BEYOND = 2.0  # times the frequency that the motion reaches; nearer, dry friction bends a rotor's inertia


def with_own_cutoff(robot: Robot, logs: Sequence[Log]) -> tuple[Robot, tuple[str, ...]]:
    """The robot with a cutoff [Hz] for its logs if it needs one and has none; and a note that says so."""
    plan = robot.settings.processing
    long = [log for log in logs if len(log) >= SHORTEST]
    if not robot.flexible or robot.controller is not None or plan.cutoff is not None or not long:
        return robot, ()
    motions = [log.signals(robot.coordinates) for log in long]
    corners, periods = [all_reached(q) for q in motions], [log.period for log in long]
    if not any(map(_blurred, motions, corners, periods)):
        return robot, ()
    reached = max(max(own) / (2 * period) for own, period in zip(corners, periods, strict=True))
    cutoff = float(f"{_BEYOND * reached:.2g}")
    if cutoff > 0.5 / max(periods):
        return robot, ()
    note = (
        "the encoders' noise, differentiated twice, blurs the accelerations: all signals pass a low pass of "
        f"{cutoff:g} Hz, {_BEYOND:g} times as far as the motion reaches; a cutoff under [processing] in the "
        "robot file takes another"
    )
    return robot.with_settings(processing=replace(plan, cutoff=cutoff)), (note,)


def _blurred(q: np.ndarray, corners: Sequence[float], period: float) -> bool:
    """Whether noise makes up much of the second differences of coordinates (N, n) that move below corners."""
    smooth = all_smooth(q, corners)
    size = np.std(np.diff(smooth, 2, axis=0), axis=0) / period**2
    noise = np.array([channel_noise(x) for x in q.T]) * np.sqrt(6) / period**2
    return bool(np.any((size > 0) & (noise > _BLURS * size)))
