"""Are the intervals honest? Monte-Carlo runs with encoder noise in the loop against the known truth."""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.logs.log import Log
from pyident.refinement.auxiliary_model import identify_by_instruments
from pyident.refinement.output_error import output_error
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.fmu_runs import FmuRuns
from pyident.simulation.replica import with_noise
from pyident.simulation.simulator import OpenPool
from pyident.sweep.code_version import code_version
from pyident.sweep.kept_results import keep, kept
from pyident.sweep.studies import StudyResult, row

LEVELS = (2e-6, 1e-5)  # rad, of the encoders at the motors; those behind the gears have half of it
RUNS = 50
DURATION = 8.2  # s


@dataclass(frozen=True)
class Estimate:
    """p, std   (P,) in the order of the robot's linear parameters; std inf where the log leaves p open."""

    p: list[float]
    std: list[float]


def run(folder: Path, progress: Callable[[float], None], runs: int = RUNS) -> StudyResult:
    """Identify `runs` logs at each level of noise; the table of deviations goes to `folder`.

    After an interruption the same call goes on: folder/logs holds what each log gave.
    """
    robot, of, rows, tables = load_robot("four_link"), code_version(own=[Path(__file__)]), [], {}
    with FmuRuns(robot) as simulate:
        for i, level in enumerate(LEVELS):
            results: dict[str, list[Estimate]] = {}
            for seed in range(runs):
                file = folder / "logs" / f"{level:g}_{seed}.json"
                found = kept(file, of)
                if found is None:
                    found = _estimates(robot, simulate, level, seed)
                    keep(file, of, found)
                for name, estimate in found.items():
                    results.setdefault(name, []).append(Estimate(**estimate))
                progress((i * runs + seed + 1) / (len(LEVELS) * runs))
            for name, listed in results.items():
                tables[name, level] = deviations(robot, listed)
                rows += _rows(f"{name}, {level:g} rad", tables[name, level])
    frame = pd.concat(tables, names=["estimator", "noise_rad", "parameter"])
    frame.to_csv(folder / "coverage.csv")
    return StudyResult(rows, [folder / "coverage.csv"])


def _estimates(robot: Robot, simulate: FmuRuns, level: float, seed: int) -> dict[str, dict[str, list[float]]]:
    """Estimator -> fields of its `Estimate` of one log."""
    log = noisy(robot, simulate, level, seed)
    found = identify_by_instruments(robot, [log], _shared(robot, simulate))
    refined = output_error(robot, [log], found, simulate)
    return {
        r.estimator: {"p": r.solution.p.tolist(), "std": r.solution.std.tolist()} for r in (found, refined)
    }


def _shared(robot: Robot, simulate: FmuRuns) -> OpenPool:
    """The processes that are there already, for every model under the robot's own controller."""
    return lambda simulated: (
        nullcontext(simulate) if simulated.controller is robot.controller else FmuRuns(simulated)
    )


def noisy(robot: Robot, simulate: FmuRuns, level: float, seed: int) -> Log:
    """The paper's experiment with white noise of the encoders, that of the motors' in the loop."""
    plan, rng = identification(robot, duration=DURATION), np.random.default_rng(seed)
    noise = {
        name: (level if name.endswith(".e") else level / 2) * rng.standard_normal(len(plan.time))
        for name in robot.coordinates
    }
    return Log(with_noise(lambda made: next(iter(simulate(made, [{}]))), plan, noise), f"noise {seed}")


def deviations(robot: Robot, results: Sequence[Estimate]) -> pd.DataFrame:
    """Per parameter with an interval in every result: coverage, mean and spread in stds, bias in %."""
    true = np.array(list(robot.linear_parameters.values()))
    alone = np.all([np.isfinite(r.std) for r in results], axis=0)
    values = np.array([r.p for r in results])[:, alone]
    z = (values - true[alone]) / np.array([r.std for r in results])[:, alone]
    names = [n for n, a in zip(robot.linear_parameters, alone, strict=True) if a]
    bias = 100 * (values.mean(axis=0) - true[alone]) / np.where(true[alone] == 0, np.nan, true[alone])
    content = {
        "coverage": (np.abs(z) < CONFIDENCE).mean(axis=0),
        "mean": z.mean(axis=0),
        "spread": z.std(axis=0),
        "bias_percent": bias,
    }
    return pd.DataFrame(content, index=names)


def _rows(name: str, table: pd.DataFrame) -> list[dict[str, str]]:
    coverage = table["coverage"].to_numpy()
    pooled, worst = float(coverage.mean()), float(coverage.min())
    stiffness = table["bias_percent"][[n for n in table.index if n.endswith(".k[1]")]].abs().max()  # pyright: ignore[reportAttributeAccessIssue]
    inertia = table["bias_percent"][[n for n in table.index if n.endswith(".J_m")]].abs().max()  # pyright: ignore[reportAttributeAccessIssue]
    return [
        row(f"95 % intervals, {name}: pooled", f"{100 * pooled:.1f} %", "93-97 %", 0.93 <= pooled <= 0.97),
        row(
            f"95 % intervals, {name}: worst of {len(table)}",
            f"{100 * worst:.0f} % ({table.index[coverage.argmin()]})",
            "86 %",
            worst >= 0.86,
        ),
        row(f"mean error of k[1], {name}", f"{stiffness:.2g} %", "1 %", bool(stiffness <= 1.0)),
        row(f"mean error of J_m, {name}", f"{inertia:.2g} %", "0.1 %", bool(inertia <= 0.1)),
    ]
