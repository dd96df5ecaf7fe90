"""Are the intervals honest? Monte-Carlo runs with sensor noise against the known truth."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.coordinate import is_torque
from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.estimation.identify import Identified, identify
from pyident.logs.log import Log
from pyident.refinement.output_error import output_error
from pyident.refinement.remove_bias import correct_by_replicas
from pyident.simulation.fmu_runs import FmuRuns
from pyident.sweep.studies import StudyResult, row

NOISE = {".e": 2e-6, ".eps": 1e-6}  # rad; torques: 0.2 % of their maximum
RUNS = 50


def run(folder: Path, progress: Callable[[float], None], runs: int = RUNS) -> StudyResult:
    """Identify `runs` noisy copies of one log; the table of deviations goes to `folder`."""
    robot = load_robot("four_link")
    with FmuRuns(robot) as simulate:
        clean = Log(next(iter(simulate(identification(robot), [{}]))), "clean")
        first = _identify(robot, _noisy(clean, 0), simulate, None)
        slopes = first[2]
        progress(0.3)

        def one(seed: int) -> tuple[Identified, Identified, list[np.ndarray]]:
            return _identify(robot, _noisy(clean, seed), simulate, slopes)

        results = []
        with ThreadPoolExecutor(2) as pool:
            for result in pool.map(one, range(1, runs + 1)):
                results.append(result[:2])
                progress(0.3 + 0.7 * len(results) / runs)
    tables = [_deviations(robot, [r[i] for r in results]) for i in (0, 1)]
    names = ("regression", "output error")
    frame = pd.concat(tables, keys=names, names=["estimator", "parameter"])
    frame.to_csv(folder / "coverage.csv")
    rows = [
        _row(name, table, strict=name == "output error") for name, table in zip(names, tables, strict=True)
    ]
    return StudyResult(rows, [folder / "coverage.csv"])


def _identify(robot: Robot, log: Log, simulate: FmuRuns, slopes: list[np.ndarray] | None):
    regression = identify(robot, [log])
    start = correct_by_replicas(robot, [log], simulate)
    refined, slopes = output_error(robot, [log], start, simulate, slopes)
    return regression, refined, slopes


def _noisy(log: Log, seed: int) -> Log:
    rng, frame = np.random.default_rng(seed), log.frame.copy()
    for name in frame:
        size = 0.002 * frame[name].abs().max() if is_torque(name) else 0.0
        for kind, level in NOISE.items():
            if name.split("[")[0].endswith(kind):
                size = level
        frame[name] += size * rng.standard_normal(len(frame))
    return Log(frame, f"noise {seed}")


def _deviations(robot: Robot, results: list[Identified]) -> pd.DataFrame:
    """Per parameter that is determined alone: coverage, bias and spread in standard deviations."""
    true = np.array(list(robot.parameters.values()))
    alone = np.all([~r.solution.open for r in results], axis=0)
    z = np.array([(r.solution.p - true)[alone] / r.solution.std[alone] for r in results])
    names = [n for n, a in zip(robot.parameters, alone, strict=True) if a]
    return pd.DataFrame(
        {"coverage": (np.abs(z) < 1.96).mean(axis=0), "bias": z.mean(axis=0), "spread": z.std(axis=0)},
        index=names,
    )


def _row(name: str, table: pd.DataFrame, strict: bool) -> dict[str, str]:
    coverage = table["coverage"].to_numpy()
    mean = float(coverage.mean())
    least = f"least {100 * coverage.min():.0f} % ({table.index[coverage.argmin()]})"
    text = f"{100 * mean:.1f} % over {len(table)} parameters; {least}"
    return row(
        f"95 % intervals that cover the truth, {name}",
        text,
        "90-99 %",
        0.9 <= mean <= 0.99 if strict else None,
    )
