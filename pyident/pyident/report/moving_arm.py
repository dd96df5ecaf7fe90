"""The arm in 3D for a page: measured and simulated motion as keyframes that the browser plays.

The browser draws rigid pose + s (pose − rigid pose): s = 1 is the robot as it is, a larger s shows
deformations, and what the simulation misses, s times their size. Poses are points in base axes, so that for
a large s links are stretched: a picture of where it bends, not of how far it would.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np
import pandas as pd

from flexmodels.coordinate import is_deformation
from flexmodels.robot import Robot
from pyident.kinematics.skeleton import segments, skeleton
from pyident.report.interactive import in_script

FRAMES = 300  # of a motion
MOST = 500.0  # times that deformations are exaggerated
_SCALE = ((0.0, "#fffaf0"), (0.2, "#fdd9a0"), (0.5, "#f3a14b"), (0.75, "#cf6214"), (1.0, "#521d02"))
_DECADES = 1.0  # of rms over the floor, from the palest colour to the darkest
_GHOST = "#b5480d"
_PLAIN = "#2b6ca3"


@dataclass(frozen=True)
class MovingArm:
    """Points [m] of joints and tip, (T, K, 3) each, at `time` (T,) [s].

    rigid, measured   the arm without deformations and as it was;  simulated: as the model says, or None
    over_floor        joint -> rms of its residual over the floor, which colours it; none: plain
    pairs             of points that a link joins, -1 the base
    """

    log: str
    time: np.ndarray
    rigid: np.ndarray
    measured: np.ndarray
    simulated: np.ndarray | None
    over_floor: Mapping[int, float]
    pairs: Sequence[tuple[int, int]]

    def content(self, height: int = 340) -> dict[str, Any]:
        """As `flexidentArm` of the script takes it."""
        moved = [] if self.simulated is None else _deltas(self.simulated, self.rigid)
        joints = self.rigid.shape[1] - 1
        worst = ", ".join(f"joint {k} {ratio:.2g} times its floor" for k, ratio in self.over_floor.items())
        return {
            "log": self.log,
            "label": f"the robot in 3D{': ' if worst else ''}{worst}",
            "height": height,
            "time": np.round(self.time, 4).tolist(),
            "rigid": np.round(self.rigid, 5).tolist(),
            "measured": _deltas(self.measured, self.rigid),
            "simulated": moved,
            "pairs": [list(pair) for pair in self.pairs],
            "colours": [*(_colour(self.over_floor.get(k + 1)) for k in range(joints)), "#1c2126"],
            "ghost": _GHOST,
            "most": MOST,
        }


def still(robot: Robot) -> MovingArm:
    """The robot in its zero pose."""
    points = skeleton(robot)
    return MovingArm(robot.name, np.zeros(1), points, points, None, {}, segments(robot))


def moving(
    robot: Robot,
    log: str,
    frame: pd.DataFrame,
    time: np.ndarray,
    missed: Mapping[str, np.ndarray],
    over_floor: Mapping[int, float],
) -> MovingArm:
    """A log and what its simulation misses. missed: signal -> (S,), log less simulation, at `time` (S,)."""
    frame = frame.iloc[-len(time) :].reset_index(drop=True)
    at = np.unique(np.linspace(0, len(time) - 1, min(FRAMES, len(time))).astype(int))
    simulated = frame.assign(**{n: frame[n] - left for n, left in missed.items() if n in frame})
    rigid = frame.drop(columns=[n for n in frame if is_deformation(str(n))])
    poses = [skeleton(robot, part.iloc[at].reset_index(drop=True)) for part in (rigid, frame, simulated)]
    return MovingArm(log, time[at], poses[0], poses[1], poses[2], over_floor, segments(robot))


def script() -> str:
    """JavaScript: `flexidentArm(element, content)` and `flexidentCursor(plot, log)`."""
    return files("pyident.report").joinpath("templates", "moving_arm.js").read_text(encoding="utf-8")


def element(arm: MovingArm, name: str) -> str:
    """The arm's place in a page that holds `script()`. name: of the element."""
    content = in_script(arm.content())
    return (
        f'<div id="{name}"></div><script>flexidentArm(document.getElementById("{name}"), {content})</script>'
    )


def _deltas(points: np.ndarray, rigid: np.ndarray) -> list[Any]:
    return np.round(points - rigid, 8).tolist()


def _colour(ratio: float | None) -> str:
    """Of a ratio to the floor, as in the map of equations; the logarithm between the scale's colours."""
    if ratio is None:
        return _PLAIN
    x = float(np.clip(np.log10(max(ratio, 1.0)) / _DECADES, 0, 1))
    places = [place for place, _ in _SCALE]
    channels = [[int(colour[i : i + 2], 16) for _, colour in _SCALE] for i in (1, 3, 5)]
    return "#" + "".join(f"{round(float(np.interp(x, places, c))):02x}" for c in channels)
