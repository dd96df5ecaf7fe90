"""Cases of which each has a file of its own, solved side by side; what is there already is kept."""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pandas as pd

from flexmodels.atomic import replacing
from pyident.simulation.processes.workers import workers_with

from .cases import Case

Solve = Callable[[None, Case, Path], None]  # importable: makes a case and writes its file into the folder


def solved(
    solve: Solve, listed: Sequence[Case], where: Path, progress: Callable[[float], None]
) -> list[dict[str, Any]]:
    """The content of every case's file."""
    left = [case for case in listed if not (where / f"{case.id}.json").is_file()]
    progress(1 - len(left) / len(listed))
    with workers_with(nullcontext) as workers:
        jobs = [workers.submit(solve, case, where) for case in left]
        for count, job in enumerate(as_completed(jobs), start=1):
            job.result()
            progress(1 - (len(left) - count) / len(listed))
    return [json.loads((where / f"{case.id}.json").read_text(encoding="utf-8")) for case in listed]


def written(where: Path, lines: Sequence[dict[str, Any]]) -> list[Path]:
    """cases.csv with a line per case."""
    with replacing(where / "cases.csv") as file:
        pd.DataFrame(list(lines)).to_csv(file, index=False)
    return [where / "cases.csv"]
