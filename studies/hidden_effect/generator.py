"""Logs of robots that hide a physical effect, for a blind study: an independent maker of measured data.

    python -m studies.hidden_effect.generator --seed 3 --cases null,stribeck -o folder

writes folder/logs/<id>/train1.parquet, train2.parquet, heldout.parquet and, apart,
folder/sealed/<id>/key.json.
"""

import argparse
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

from . import generator_cases
from .generator_cases import LOGS, UNOBSERVABLE, Basis, Case
from .generator_laws import LAWS
from .generator_run import (
    NOISELESS,
    Hidden,
    Noise,
    Plan,
    UnstableLoop,
    simulate,
    simulate_all,
    standard,
)

_DRAWS = 5  # of a case whose loop is unstable

__all__ = [
    "LAWS",
    "LOGS",
    "NOISELESS",
    "UNOBSERVABLE",
    "Case",
    "Hidden",
    "Noise",
    "Plan",
    "case_list",
    "cases_of",
    "generate",
    "simulate",
    "standard",
]


def case_list(seed: int, robot: str = "four_link", nulls: int = 12, amplitude: float = 1.0) -> list[Case]:
    """Every case of the study, in an order that says nothing: the same for the same seed."""
    return generator_cases.case_list(Basis.of(load_robot(robot)), seed, nulls, amplitude)


def cases_of(specs: Sequence[str], seed: int, robot: str = "four_link", amplitude: float = 1.0) -> list[Case]:
    """Chosen cases: `null`, `stribeck`, `stribeck@2`, `stribeck@2+backlash@3`, names of UNOBSERVABLE."""
    basis = Basis.of(load_robot(robot))
    return [generator_cases.single(spec, basis, seed + i, amplitude) for i, spec in enumerate(specs)]


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
            case = generator_cases.redrawn(case)
    return case, _runs(case, jobs)


def _runs(case: Case, jobs: int) -> list[tuple[pd.DataFrame, pd.DataFrame]]:
    if jobs == 1:
        return [_run(case, i) for i in range(len(LOGS))]
    with ProcessPoolExecutor(jobs) as pool:
        return list(pool.map(_run, repeat(case), range(len(LOGS))))


def _run(case: Case, i: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    return simulate_all(case.robot, case.laws, case.plans[i], case.seed + i, case.noise)


def _generate_all(case: Case, folder: Path) -> str:
    generate(case, folder)
    return case.id


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


def main(arguments: Sequence[str] | None = None) -> None:
    """The command; prints the ids of what it has written."""
    parser = argparse.ArgumentParser(prog="python -m studies.hidden_effect.generator", description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", default="all", help="all, or with commas: null, LAW, LAW@JOINT, LAW+LAW")
    parser.add_argument("--robot", default="four_link", help="a shipped robot or a file")
    parser.add_argument("--amplitude", type=float, default=1.0, help="1 is strong, 0.25 is faint")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, required=True)
    a = parser.parse_args(arguments)
    if a.cases == "all":
        cases = case_list(a.seed, a.robot, amplitude=a.amplitude)
    else:
        cases = cases_of(a.cases.split(","), a.seed, a.robot, a.amplitude)
    with ProcessPoolExecutor(a.jobs) as pool:
        for done in pool.map(_generate_all, cases, repeat(a.output)):
            print(done, flush=True)


if __name__ == "__main__":
    main()
