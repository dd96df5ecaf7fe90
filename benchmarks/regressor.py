"""Speed of Phi on one core: compiled, by NumPy, and Pinocchio's joint torque regressor.

    python -m benchmarks.regressor -o out

Pinocchio's robot is the same arm as a chain of four revolute joints per flexible joint; its regressor holds
the links' columns of every massless body too. It has no friction, stiffness or damping columns; ours has.
Every sample's result is stored. figaroh stacks Pinocchio's regressor of every sample.
"""

import sys
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from benchmarks.measure import best, on_one_core
from benchmarks.results import command, drawn, keep

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.links import LinkColumns
from pyident.regression.regressor import regressor_blocks


def random_motion(robot: Robot, samples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, dq, ddq (samples, n); small enough for deformations."""
    rng, shape = np.random.default_rng(0), (samples, len(robot.coordinates))
    return rng.uniform(-0.2, 0.2, shape), rng.uniform(-2, 2, shape), rng.uniform(-5, 5, shape)


def with_joints(robot: Robot, joints: int) -> Robot:
    """An arm of so many joints: the robot's own, repeated from its first on."""
    chosen = [k % len(robot.joints) for k in range(joints)]
    return replace(
        robot,
        name=f"{joints}_joints",
        joints=tuple(robot.joints[k] for k in chosen),
        links=tuple(robot.links[k] for k in chosen),
        controller=None,
    )


def our_speed(robot: Robot, samples: int) -> float:
    """Samples per second, block by block."""
    motion = Motion(*random_motion(robot, samples))
    _run(robot, motion)  # compiles
    return samples / best(lambda: _run(robot, motion))


def numpy_speed(robot: Robot, samples: int) -> float:
    """The same without the compiled part."""
    filled = LinkColumns.fill
    LinkColumns.fill = LinkColumns._fill_by_numpy
    try:
        return our_speed(robot, samples)
    finally:
        LinkColumns.fill = filled


def rows(joints: list[int], samples: int) -> list[dict[str, Any]]:
    """Samples per second of every tool for the arms of so many joints; at 4 also what is slow to build."""
    found: list[dict[str, Any]] = []
    for count in joints:
        robot = with_joints(load_robot("four_link"), count)
        speeds: dict[str, float | str] = {"pyident, compiled": our_speed(robot, samples)}
        if count == 4:
            speeds["pyident, NumPy"] = numpy_speed(robot, max(samples // 10, 1))
        if find_spec("pinocchio"):
            speeds |= _pinocchio(robot, max(samples // 20, 1), with_cpp=count == 4)
        for tool, speed in speeds.items():
            if isinstance(speed, str):
                print(f"note: {tool} is left out: {speed}", file=sys.stderr)
            else:
                found.append({"joints": count, "tool": tool, "samples per second": speed})
    return found


def figure(table: pd.DataFrame, path: Path) -> None:
    with drawn(path) as (ax,):
        for tool, group in table.groupby("tool", sort=False):
            ax.semilogy(group["joints"], group["samples per second"], "o-", label=tool)
        ax.set(xlabel="joints of the arm", ylabel="samples per second, one core")


def _pinocchio(robot: Robot, samples: int, with_cpp: bool) -> dict[str, float | str]:
    from benchmarks.peers.pinocchio_loop import cpp_speed, figaroh_speed, python_speed
    from benchmarks.peers.pinocchio_plant import pinocchio_model

    model, motion = pinocchio_model(robot), random_motion(robot, samples)
    speeds: dict[str, float | str] = {"Pinocchio, loop in Python": python_speed(model, motion)}
    if find_spec("figaroh"):
        speeds["figaroh, on Pinocchio"] = figaroh_speed(model, motion)
    return speeds | ({"Pinocchio, loop in C++": cpp_speed(model, motion)} if with_cpp else {})


def _run(robot: Robot, motion: Motion) -> None:
    for _ in regressor_blocks(robot, motion):
        pass


def main() -> int:
    parser = command(__doc__)
    parser.add_argument("--joints", type=int, nargs="+", default=[1, 2, 3, 4, 6, 8, 12])
    parser.add_argument("--samples", type=int, default=60_000)
    given = parser.parse_args()
    on_one_core()
    keep(pd.DataFrame(rows(given.joints, given.samples)), "regressor", given.out, figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
