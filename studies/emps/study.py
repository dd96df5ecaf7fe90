"""EMPS: a measured axis, identified with symmetric and with direction-dependent friction.

And the model of it that is to predict another record in free run, `benchmark.toml`.
"""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from flexmodels.coordinate import reference_of
from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.robot import Robot
from pyident.estimation.identify import Identified, identify
from pyident.logs.log import read_log
from pyident.sweep.studies import StudyResult, row

from .benchmark import Judged, judged, simplest

# Janot, Gautier and Brunot, Data set and reference models of EMPS, 2019.
SYMMETRIC = {"M": 95.1089, "Fv": 203.5034, "Fc": 20.3935, "offset": -3.1648}
DIRECTIONAL = {"M": 95.1540, "Fv+": 166.7061, "Fc+": 20.1440, "Fv-": 240.4236, "Fc-": 20.6277}
ERROR = {"symmetric": 4.0834, "directional": 3.1117}


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Identify the measured file and leave the benchmark's model in `folder`. Without the data: no rows."""
    file = Path(os.environ.get("PYIDENT_DATA", "data")) / "emps" / "DATA_EMPS.mat"
    if not file.is_file():
        return StudyResult(
            [], notes=[f"skipped: {file} is not there; set PYIDENT_DATA to the folder of data sets"]
        )
    robot = load_robot("emps")
    log = read_log(file, robot.settings.columns)
    symmetric = identify(robot, [log])
    directional = identify(robot.with_effect(1, "asymmetric_coulomb"), [log])
    progress(0.02)
    found = symmetric.robot.parameters
    start = {name: found[name] for name in ("joint1.viscous", "joint1.coulomb", "joint1.offset")}
    start |= {"link1.m": _mass(symmetric.robot), "joint1.J_m": 0.0}
    results = judged(robot, log, start, lambda share: progress(0.02 + 0.98 * share))
    taken = simplest(results)
    target = folder / "benchmark.toml"
    save_robot(_described(taken), target)
    return StudyResult(
        [
            *_rows("symmetric", SYMMETRIC, _symmetric(symmetric), symmetric),
            *_rows("directional", DIRECTIONAL, _directional(directional), directional),
            *(_free_run_row(result) for result in results),
        ],
        notes=[
            f"taken: {taken.structure.name}; wrote {target}. Its free run misses {taken.trained:.2f} mm rms "
            f"of the record that it was fitted to, and of parts held out {taken.error:.2f} mm on average"
        ],
    )


def _described(taken: Judged) -> Robot:
    text = (
        f"EMPS for free runs from the voltage: {taken.structure.name} friction, fitted to DATA_EMPS.mat "
        f"alone ({taken.trained:.2f} mm rms there, {taken.error:.2f} mm on parts held out)."
    )
    needed = {name: c for name, c in taken.robot.settings.columns.items() if name != reference_of(1)}
    return replace(taken.robot, name="emps_benchmark", description=text).with_settings(columns=needed)


def _free_run_row(result: Judged) -> dict[str, str]:
    ahead, back, *quarters = result.heldout
    quarter = ", ".join(f"{error:.2f}" for error in quarters)
    value = f"{result.trained:.2f} fitted; halves {ahead:.2f}, {back:.2f}; quarters {quarter}"
    what = f"free run [mm], {result.structure.name} ({result.size} parameters)"
    return row(what, f"{value}; mean of held out {result.error:.2f}")


def _mass(robot: Robot) -> float:
    p = robot.parameters
    return p["link1.m"] + p["joint1.J_m"]


def _symmetric(found: Identified) -> dict[str, float]:
    p = found.robot.parameters
    return {
        "M": _mass(found.robot),
        "Fv": p["joint1.viscous"],
        "Fc": p["joint1.coulomb"],
        "offset": p["joint1.offset"],
    }


def _directional(found: Identified) -> dict[str, float]:
    p = found.robot.parameters
    level = p["joint1.offset"] + p["joint1.asymmetric_coulomb.coulomb"]
    slope = p["joint1.asymmetric_coulomb.viscous"]
    return {
        "M": _mass(found.robot),
        "Fv+": p["joint1.viscous"] + slope,
        "Fc+": p["joint1.coulomb"] + level,
        "Fv-": p["joint1.viscous"] - slope,
        "Fc-": p["joint1.coulomb"] - level,
    }


def _rows(
    model: str, published: dict[str, float], found: dict[str, float], result: Identified
) -> list[dict[str, str]]:
    rows = []
    for name, value in found.items():
        off = 100 * (value / published[name] - 1)
        text = f"{value:.5g} ({off:+.2f} % of the published {published[name]:.5g})"
        rows.append(row(f"{model} friction: {name}", text, "0.5 %", abs(off) <= 0.5))
    error = result.relative_error["all"]
    goal = f"{ERROR[model]:.2f} ± 0.1 %"
    rows.append(
        row(f"{model} friction: relative error", f"{error:.2f} %", goal, abs(error - ERROR[model]) <= 0.1)
    )
    return rows
