"""Every estimator on the same logs: bias, spread, coverage of its intervals, seconds."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pyident.estimation.identify import Identified
from pyident.logs.log import LogError
from pyident.refinement.identifications import DEFAULT, IDENTIFICATIONS
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.fmu_runs import runs_in_threads
from pyident.sweep.studies import StudyResult, row

from .cases import Case, cases, measured

RUNS = 10


@dataclass(frozen=True)
class Score:
    """Of parameters that the logs determine alone [%]: median and largest |bias|, median spread.

    coverage   share of the 95 % intervals that hold the truth, nan where there are none
    seconds    CPU time of a log;  refused: why the estimator does not take these logs
    """

    bias: float = np.nan
    worst: float = np.nan
    spread: float = np.nan
    coverage: float = np.nan
    seconds: float = np.nan
    refused: str = ""


def run(folder: Path, progress: Callable[[float], None], runs: int = RUNS) -> StudyResult:
    """`runs` logs per case, each by every estimator; the table goes to `folder`."""
    listed, table, notes = cases(), [], [f"{runs} logs per case"]
    try:
        listed.append(measured())
        notes.append(f"{listed[-1].logs} of {listed[-1].name}; there bias is off what was published")
    except LogError as error:
        notes.append(f"the TX40 is left out: {error}")
    for i, case in enumerate(listed):
        scores = scored(case, runs, lambda share, i=i: progress((i + share) / len(listed)))
        table += [{"case": case.name, "estimator": name, **vars(score)} for name, score in scores.items()]
        pd.DataFrame(table).to_csv(folder / "estimators.csv", index=False)
    rows = [_row(line["case"], line["estimator"], line) for line in table]
    return StudyResult(rows, [folder / "estimators.csv"], notes)


def scored(case: Case, runs: int, progress: Callable[[float], None]) -> dict[str, Score]:
    """Estimator -> its score on logs 0 to runs - 1 of the case, or on all that there are."""
    runs = runs if case.logs is None else min(runs, case.logs)
    found: dict[str, list[Identified]] = {name: [] for name in IDENTIFICATIONS}
    spent, refused = dict.fromkeys(IDENTIFICATIONS, 0.0), {}
    for seed in range(runs):
        log = case.log(seed)
        for j, (name, identification) in enumerate(IDENTIFICATIONS.items()):
            if name not in refused:
                began = time.process_time()
                try:
                    found[name].append(identification(case.robot, [log], runs_in_threads))
                except LogError as error:
                    refused[name] = str(error)
                spent[name] += time.process_time() - began
            progress((seed + (j + 1) / len(found)) / runs)
    alone = [name for name in determined(found[DEFAULT]) if name in case.true]
    return {
        name: Score(refused=refused[name])
        if name in refused
        else score(case.true, results, alone, spent[name] / runs)
        for name, results in found.items()
    }


def determined(results: Sequence[Identified]) -> list[str]:
    """Parameters that every result says its log determines alone."""
    return [n for n in results[0].support if all(r.support[n] == "alone" for r in results)]


def score(
    true: dict[str, float], results: Sequence[Identified], names: Sequence[str], seconds: float
) -> Score:
    """Of the named parameters; relative errors of those that are not zero."""
    place = [results[0].reduced.columns.index(name) for name in names]
    right = np.array([true[name] for name in names])
    values = np.array([r.solution.p[place] for r in results])
    std = np.array([r.solution.std[place] for r in results])
    size = np.where(right == 0, np.nan, np.abs(right))
    bias = 100 * np.abs(values.mean(axis=0) - right) / size
    spread = 100 * values.std(axis=0) / size
    told = np.isfinite(std)
    held = np.abs(values - right)[told] < CONFIDENCE * std[told]
    return Score(
        bias=float(np.nanmedian(bias)),
        worst=float(np.nanmax(bias)),
        spread=float(np.nanmedian(spread)),
        coverage=float(100 * held.mean()) if told.any() else np.nan,
        seconds=seconds,
    )


def _row(case: str, name: str, line: dict) -> dict[str, str]:
    if line["refused"]:
        return row(f"{case}: {name}", f"not possible: {line['refused']}")
    coverage = "no intervals" if np.isnan(line["coverage"]) else f"{line['coverage']:.0f} % held"
    text = (
        f"bias {line['bias']:.2g} % (worst {line['worst']:.2g} %), spread {line['spread']:.2g} %, "
        f"{coverage}, {line['seconds']:.1f} s"
    )
    return row(f"{case}: {name}", text)
