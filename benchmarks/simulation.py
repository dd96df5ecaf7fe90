"""Speed at equal accuracy: our FMU, MuJoCo and Pinocchio on the same arm, motion and controller.

    python -m benchmarks.simulation -o out

One second of the paper's identification experiment with four_link: digital PID at 250 Hz, held torque,
gravity, viscous and Coulomb friction, flexible hinges; and the same without Coulomb friction, where every
tool solves the same equations. Error: the largest distance of the tip from an event-exact reference, over the
samples of the controller. Time: CPU time of one thread, best of three; loading a model is not counted.
"""

import argparse
import os
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"

import matplotlib as mpl
import numpy as np
import pandas as pd
from benchmarks.cases import Case, Point, case, timed, without_coulomb
from benchmarks.fmu_points import fmu_costs, fmu_points
from benchmarks.peers.closed_loop import Plant, run

from flexmodels.coordinate import of_joint
from flexmodels.files.robot_file import load_robot

GOAL = 10.0  # um
RK4_STEPS = (1e-3, 0.8e-3, 0.5e-3, 0.2e-3, 0.1e-3)  # s
IMPLICITFAST_STEPS = (0.5e-3, 0.2e-3, 0.1e-3, 0.004 / 60, 0.02e-3)  # s; at 1 ms it is unstable
PEERS = {"mujoco": "mujoco", "pinocchio": "pin"}  # module -> package


def points(case: Case) -> Iterator[Point]:
    """Every tool that is installed at every setting."""
    yield from fmu_points(case)
    if find_spec("mujoco"):
        yield from mujoco_points(case)
    if find_spec("pinocchio"):
        yield from pinocchio_points(case)


def mujoco_points(case: Case) -> Iterator[Point]:
    from benchmarks.peers.mujoco_plant import Integrator, MujocoPlant, Settings

    dry = any(case.robot.parameters[of_joint(k, "coulomb")] for k, _ in case.robot.numbered)
    plans: dict[Integrator, tuple[float, ...]] = {"RK4": RK4_STEPS, "implicitfast": IMPLICITFAST_STEPS}
    for integrator, steps in plans.items():
        for stiff in (False, True) if dry else (False,):
            tool = f"MuJoCo {integrator}" + (", stiff frictionloss" if stiff else "")
            for step in steps:
                plant = MujocoPlant(case.robot, Settings(integrator, step, stiff))
                yield _point(case, tool, step, plant)


def pinocchio_points(case: Case) -> Iterator[Point]:
    """The Python loop, and as a bound on a loop in C++ the time of its aba calls alone."""
    from benchmarks.peers.pinocchio_plant import PinocchioPlant

    for step in RK4_STEPS:
        plant = PinocchioPlant(case.robot, step)
        point = _point(case, "Pinocchio RK4 in Python", step, plant)
        yield point
        calls = 4 * plant.steps * (len(case.experiment.time) - 1)
        alone = case.duration / (calls * plant.seconds_per_call())
        yield Point("Pinocchio, its aba calls alone", point.setting, point.error, alone)


def _point(case: Case, tool: str, step: float, plant: Plant) -> Point:
    seconds, tip = timed(lambda: run(plant, case.robot, case.experiment, case.start))
    return Point(tool, f"step = {step:g}", case.error(tip), case.duration / seconds)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Per case and tool the fastest setting within GOAL, or the most accurate one if there is none."""
    rows = []
    for _, group in table.groupby(["case", "tool"], sort=False):
        good = group.query(f"`tip error [um]` <= {GOAL}")
        best = good.sort_values("speed").tail(1) if len(good) else group.sort_values("tip error [um]").head(1)
        verdict = f"within {GOAL:g} um" if len(good) else f"never within {GOAL:g} um: its best"
        rows.append(best.assign(verdict=verdict))
    return pd.concat(rows)


def figure(table: pd.DataFrame, path: Path) -> None:
    """Work-precision: one panel per case, up and left is better."""
    mpl.use("agg")
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys(table["case"]))
    tools = list(dict.fromkeys(table["tool"]))
    fig, axes = plt.subplots(
        1, len(names), figsize=(11, 4.6), sharey=True, squeeze=False, layout="constrained"
    )
    for ax, name in zip(axes[0], names, strict=True):
        for i, tool in enumerate(tools):
            rows = table[(table["case"] == name) & (table["tool"] == tool) & np.isfinite(table["speed"])]
            style = {"lw": 2.5, "ms": 7} if tool.startswith("flexident") else {"lw": 1.2, "ms": 5}
            ax.loglog(rows["tip error [um]"], rows["speed"], "osD^vPX*"[i % 8] + "-", label=tool, **style)
        ax.axvline(GOAL, color="0.5", ls="--", lw=1)
        ax.set(title=name, xlabel="largest tip error over 1 s [µm]")
        ax.grid(alpha=0.3, which="major")
    axes[0, 0].set_ylabel("simulated seconds per CPU second")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=9)
    fig.savefig(path, dpi=150)
    plt.close(fig)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument(
        "-o", "--out", type=Path, default=Path("out"), help="folder of the tables and the figure"
    )
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    for module, package in PEERS.items():
        if not find_spec(module):
            print(f"note: {module} is left out, it is not installed; pip install {package}")
    robot = load_robot("four_link")
    rows, costs = [], pd.DataFrame()
    for name, variant in (("Coulomb friction", robot), ("no Coulomb friction", without_coulomb(robot))):
        print(f"{name}: the reference ...", file=sys.stderr)
        measured = case(name, variant)
        costs = fmu_costs(measured) if costs.empty else costs
        for p in points(measured):
            print(f"{name}: {p.tool}, {p.setting}", file=sys.stderr)
            rows.append((name, p.tool, p.setting, p.error, p.speed))
    table = pd.DataFrame(rows, columns=["case", "tool", "setting", "tip error [um]", "speed"])
    best = summary(table)
    table.to_csv(out / "simulation.csv", index=False)
    best.to_csv(out / "simulation_summary.csv", index=False)
    figure(table, out / "simulation.png")
    print("\nspeed: simulated seconds per CPU second; settings in SI units")
    for text in (table, best):
        print(text.to_string(index=False, float_format="{:.3g}".format), end="\n\n")
    print(costs.to_string(float_format="{:.3g}".format))
    return 0


if __name__ == "__main__":
    sys.exit(main())
