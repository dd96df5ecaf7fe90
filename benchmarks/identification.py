"""From logs to parameters and to a verdict: three logs of 20 s of four_link with encoder noise, all cores.

    python -m benchmarks.identification -o out

lstsq       the regressor stored, columns scaled, numpy.linalg.lstsq: what a script of one's own would do
others      `pyident identify --estimator ...` and `pyident diagnose`, from logs in memory

Wall time is what a user waits for; CPU time is that of all processes. What a first call keeps for later ones
(compiled columns, objects of the FMU) is there: `wls` and `iv` run once before.
"""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from benchmarks.results import command, drawn, keep

import pyident as pi
from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.logs.log import Log
from pyident.regression.regressor import regressor
from pyident.simulation.fmu_runs import fmu_here

SECONDS, LEVEL = 20.0, 2e-6  # of a log; rad of the motors' encoders, those behind the gears have half of it
_CLOCK = 0.01  # s: what the system counts CPU time in
GOALS = {"iv": 20.0, "diagnose": 40.0}  # s wall, on two quiet cores


def logs(robot: Robot, seconds: float) -> list[Log]:
    """The paper's experiment three times, under different noise that goes through the loop."""
    noise = {name: LEVEL if name.endswith(".e") else LEVEL / 2 for name in robot.coordinates}
    with fmu_here(robot) as fmu:
        frames = fmu.simulate_batch(identification(robot, duration=seconds), [{}], noise, [1, 2, 3])
    return [Log(frame, f"log {i}") for i, frame in enumerate(frames, start=1)]


def by_lstsq(robot: Robot, given: list[Log]) -> np.ndarray:
    """(P,) least squares of all equations."""
    parts = [condition(log, robot) for log in given]
    use = [part.use.ravel()[:, None] for part in parts]
    Phi = [regressor(robot, part.motion).matrix for part in parts]
    A = np.concatenate([x.reshape(len(u), -1) * u for x, u in zip(Phi, use, strict=True)])
    y = np.concatenate([part.target.ravel() * u[:, 0] for part, u in zip(parts, use, strict=True)])
    scale = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    return np.linalg.lstsq(A / scale, y, rcond=1e-10)[0] / scale


def rows(seconds: float = SECONDS, verdict: bool = True) -> list[dict[str, Any]]:
    """What each way takes [s], and how many times `lstsq` takes that."""
    robot = load_robot("four_link")
    given = logs(robot, seconds)
    ways: dict[str, Callable[[], object]] = {"lstsq": lambda: by_lstsq(robot, given)}
    for name in ("wls", "iv", "oe"):
        ways[name] = lambda name=name: pi.identify(robot, given, estimator=name)
    if verdict:
        ways["diagnose"] = lambda: pi.diagnose(robot, given[:2], heldout=given[2:])
    found = []
    for name, work in ways.items():
        if name in ("wls", "iv"):
            work()
        wall, cpu = time.perf_counter(), sum(os.times()[:4])
        work()
        wall, cpu = time.perf_counter() - wall, sum(os.times()[:4]) - cpu
        found.append({"way": name, "wall [s]": wall, "CPU [s]": cpu, "goal, wall [s]": GOALS.get(name)})
    least = max(found[0]["CPU [s]"], _CLOCK)
    return [row | {"times lstsq [CPU]": max(row["CPU [s]"], _CLOCK) / least} for row in found]


def figure(table: pd.DataFrame, path: Path) -> None:
    with drawn(path) as axes:
        axes[0].barh(table["way"], table["wall [s]"])
        axes[0].set(xlabel="wall time [s]")


def main() -> int:
    parser = command(__doc__)
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of each log")
    given = parser.parse_args()
    keep(pd.DataFrame(rows(given.seconds)), "identification", given.out, figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
