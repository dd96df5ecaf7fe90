"""A plan as other controllers read it: time tables and ROS messages."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from flexmodels.atomic import replacing
from flexmodels.experiment import Experiment
from flexmodels.robot import Robot, RobotError
from pyident.excitation.fourier import Reference
from pyident.excitation.rehearsals.rehearsal import reference_of_plan
from pyident.excitation.rehearsals.violations import at_rest

ENDINGS = (".csv", ".json", ".yaml")


def write_table(robot: Robot, plan: Experiment, path: str | Path, rate: float, degrees: bool = False) -> Path:
    """Write references every 1/rate [s]: a table (.csv), or a ROS JointTrajectory (.json or .yaml).

    degrees   of hinges, and mm of sliders, in a table; a ROS message is always in SI units
    The feed-forward torque is not in any of them. Raises RobotError.
    """
    path = Path(path)
    if path.suffix not in ENDINGS:
        raise RobotError(f"{path}: a trajectory must end in {', '.join(ENDINGS)}")
    if degrees and path.suffix != ".csv":
        raise RobotError(f"{path}: a ROS message is in SI units; degrees are for a table (.csv)")
    motion = _thinned(plan, rate)
    with replacing(path) as file:
        if path.suffix == ".csv":
            table(robot, motion, degrees).to_csv(file, index=False)
        elif path.suffix == ".json":
            file.write_text(json.dumps(message(robot, motion), indent=1) + "\n", encoding="utf-8")
        else:
            file.write_text(_yaml(message(robot, motion)), encoding="utf-8")
    return path


def table(robot: Robot, motion: Reference, degrees: bool = False) -> pd.DataFrame:
    """A row per time: positions and speeds of the joints under their own names, with units other than SI."""
    out = {"time": motion.time}
    for what, values, per in (("position", motion.q, ""), ("speed", motion.dq, "/s")):
        for k, joint in robot.numbered:
            unit, factor = ("deg", np.degrees(1.0)) if joint.kind == "revolute" else ("mm", 1000.0)
            name = f"{joint.name or f'joint{k}'}.{what}"
            if degrees:
                out[f"{name} [{unit}{per}]"] = factor * values[:, k - 1]
            else:
                out[name] = values[:, k - 1]
    return pd.DataFrame(out)


def message(robot: Robot, motion: Reference) -> dict[str, Any]:
    """trajectory_msgs/JointTrajectory."""
    points = []
    for t, q, dq, ddq in zip(motion.time, motion.q, motion.dq, motion.ddq, strict=True):
        nanoseconds = round(float(t) * 1e9)
        points.append(
            {
                "positions": q.tolist(),
                "velocities": dq.tolist(),
                "accelerations": ddq.tolist(),
                "effort": [],
                "time_from_start": {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9},
            }
        )
    names = [joint.name or f"joint{k}" for k, joint in robot.numbered]
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": names,
        "points": points,
    }


def _thinned(plan: Experiment, rate: float) -> Reference:
    motion = reference_of_plan(plan)
    own = 1 / float(plan.time[1] - plan.time[0])
    every = round(own / rate) if own / len(plan.time) < rate < np.inf else 0
    if every < 1 or abs(own / every - rate) > 1e-6 * rate:
        raise RobotError(
            f"a plan of {own:g} points per second cannot be written at {rate:g}; divide it evenly"
        )
    rest = at_rest(motion, np.abs(motion.dq).max(axis=0))
    for end, still in zip((0, -1), rest, strict=True):  # differences leave a little, which ROS 2 refuses
        motion.dq[end, still] = motion.ddq[end, still] = 0.0
    last = len(motion.time) - 1
    kept = np.append(np.arange(0, last, every), last)  # a motion that is cut off does not end at rest
    return Reference(motion.time[kept], motion.q[kept], motion.dq[kept], motion.ddq[kept])


def _yaml(content: dict[str, Any]) -> str:
    """Every JSON text of one line is YAML's flow style: keys stand below each other, points in a line."""
    lines = [f"{key}: {json.dumps(content[key])}" for key in ("header", "joint_names")]
    return "\n".join([*lines, "points:", *(f"- {json.dumps(p)}" for p in content["points"])]) + "\n"
