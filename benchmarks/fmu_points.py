"""Our FMU through FMPy: work-precision, and what FMPy and the interface take of it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
from benchmarks.cases import Case, Point, timed

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.inputs import Experiment, SimulationError

TOOL = "flexident FMU"
WITH_START = "flexident FMU, start-up included"
FACTORS = (2.0, 1.6, 1.0, 0.4, 0.2)  # of the setting that the FMU starts with
TIP = ["tip.x", "tip.y", "tip.z"]


def fmu_points(case: Case) -> Iterator[Point]:
    """Start-up (load the library, instantiate, initialise) is left out of TOOL: so it is of the peers."""
    with TemporaryDirectory() as folder, LoadedFmu(export_fmu(case.equations, Path(folder) / "x.fmu")) as fmu:
        name, value = solver_setting(fmu)
        start_up = _start_up(fmu, case.experiment)
        for setting in (factor * value for factor in FACTORS):
            try:
                seconds, log = timed(lambda s=setting: fmu.simulate(case.experiment, {name: s}))
            except SimulationError:
                yield Point(TOOL, f"{name} = {setting:g}", np.inf, np.nan)
                continue
            error = case.error(log[TIP].to_numpy())
            yield Point(TOOL, f"{name} = {setting:g}", error, case.duration / (seconds - start_up))
            yield Point(WITH_START, f"{name} = {setting:g}", error, case.duration / seconds)


def fmu_costs(case: Case) -> pd.DataFrame:
    """Where the CPU time of one simulated second goes at the FMU's own setting.

    A ramp, which the FMU interpolates, takes the solver the same work in long and in short communication
    steps; the difference is what a communication step takes (set, step, get by FMPy, ctypes and our C).
    """
    with TemporaryDirectory() as folder, LoadedFmu(export_fmu(case.equations, Path(folder) / "x.fmu")) as fmu:
        joints, seconds = len(case.robot.joints), 4
        ramps = []
        for samples in (250 * seconds, 1):
            grid = np.linspace(0, seconds, samples + 1)
            ramps.append(
                Experiment(grid, np.outer(grid, np.full(joints, 0.1)), np.zeros((len(grid), joints)))
            )
        short, long = (timed(lambda r=ramp: fmu.simulate(r), repeats=10)[0] for ramp in ramps)
        start_up = _start_up(fmu, case.experiment)
        total = timed(lambda: fmu.simulate(case.experiment), repeats=10)[0]
        name, value = solver_setting(fmu)
    step = (short - long) / (250 * seconds - 1)
    rows = {
        "whole run": total,
        "start-up, once per run": start_up,
        f"{len(case.experiment.time) - 1} communication steps": step * (len(case.experiment.time) - 1),
    }
    rows["solver"] = 2 * total - sum(rows.values())
    frame = pd.DataFrame({"CPU time [ms]": {key: 1e3 * s for key, s in rows.items()}})
    frame["simulated s per CPU s"] = case.duration / (frame["CPU time [ms]"] / 1e3)
    return frame.rename_axis(f"{name} = {value:g}")


def solver_setting(fmu: LoadedFmu) -> tuple[str, float]:
    """Name and start value of the parameter that sets the solver's accuracy."""
    for variable in fmu.description.modelVariables:
        if variable.name.startswith("solver.") and variable.start:
            return variable.name, float(variable.start)
    raise ValueError("the FMU has no parameter solver.*, so its accuracy cannot be varied")


def _start_up(fmu: LoadedFmu, experiment: Experiment) -> float:
    first = replace(
        experiment,
        time=experiment.time[:1],
        reference=experiment.reference[:1],
        feedforward=experiment.feedforward[:1],
    )
    return timed(lambda: fmu.simulate(first), repeats=10)[0]
