"""A case's logs and its key, in folders apart."""

import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from itertools import repeat
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.atomic import replacing
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot

from . import cases
from .cases import LOGS, Basis, Case
from .run import UnstableLoop, simulate_all

_DRAWS = 5  # of a case whose loop is unstable


def case_list(seed: int, robot: str = "four_link", nulls: int = 12, amplitude: float = 1.0) -> list[Case]:
    """Every case of the study, in an order that says nothing: the same for the same seed."""
    return cases.case_list(Basis.of(load_robot(robot)), seed, nulls, amplitude)


def cases_of(specs: Sequence[str], seed: int, robot: str = "four_link", amplitude: float = 1.0) -> list[Case]:
    """Chosen cases: `null`, `stribeck`, `stribeck@2`, `stribeck@2+backlash@3`, names of UNOBSERVABLE."""
    basis = Basis.of(load_robot(robot))
    return [cases.single(spec, basis, seed + i, amplitude) for i, spec in enumerate(specs)]


def generate(case: Case, folder: Path, jobs: int = 1) -> list[Path]:
    """Write a case's three logs below folder/logs and its key below folder/sealed; paths of the logs.

    key.json holds kind, laws (law, joint, constants), true parameters, plans, and per log and row the rms of
    the hidden force [N m] and its share of the rms of the row's torque (motor torque or stiffness times
    deformation).
    """
    case, runs = _running(case, jobs)
    open_folder, sealed = Path(folder) / "logs" / case.id, Path(folder) / "sealed" / case.id
    for place in (open_folder, sealed):
        place.mkdir(parents=True, exist_ok=True)
    paths = [open_folder / f"{name}.parquet" for name in LOGS]
    for path, (frame, _) in zip(paths, runs, strict=True):
        with replacing(path) as file:
            frame.to_parquet(file, index=False)
    key = {
        "id": case.id,
        "kind": case.kind,
        "laws": [asdict(law) for law in case.laws],
        "parameters": case.robot.parameters,
        "seed": case.seed,
        "noise": asdict(case.noise),
        "plans": {name: asdict(plan) for name, plan in zip(LOGS, case.plans, strict=True)},
        "shares": {name: _shares(case.robot, *run) for name, run in zip(LOGS, runs, strict=True)},
    }
    with replacing(sealed / "key.json") as file:
        file.write_text(json.dumps(key, indent=2), encoding="utf-8")
    return paths


def _running(case: Case, jobs: int) -> tuple[Case, list[tuple[pd.DataFrame, pd.DataFrame]]]:
    """The case and its runs; drawn again where the hidden law makes the loop unstable."""
    for _ in range(_DRAWS - 1):
        try:
            return case, _runs(case, jobs)
        except UnstableLoop:
            case = cases.redrawn(case)
    return case, _runs(case, jobs)


def _runs(case: Case, jobs: int) -> list[tuple[pd.DataFrame, pd.DataFrame]]:
    if jobs == 1:
        return [_run(case, i) for i in range(len(LOGS))]
    with ProcessPoolExecutor(jobs) as pool:
        return list(pool.map(_run, repeat(case), range(len(LOGS))))


def _run(case: Case, i: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    return simulate_all(case.robot, case.laws, case.plans[i], case.seed + i, case.noise)


def _shares(robot: Robot, frame: pd.DataFrame, forces: pd.DataFrame) -> dict[str, dict[str, float]]:
    shares = {}
    for name in robot.coordinates:
        rms = float(np.sqrt(np.mean(forces[name] ** 2)))
        if rms:
            joint, _, coordinate = name.partition(".")
            if coordinate == "e":
                row = frame[f"{joint}.tau"]
            else:
                row = robot.parameters[name.replace("eps", "k")] * frame[name]
            shares[name] = {"rms": rms, "share": rms / float(np.sqrt(np.mean(row**2)))}
    return shares
