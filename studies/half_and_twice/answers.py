"""What is said of every case, or by every variant, in a file each; and the table that comes of them."""

import json
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import as_completed
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pandas as pd
from threadpoolctl import threadpool_limits

from flexmodels.atomic import replacing
from pyident.simulation.processes.workers import workers_with
from pyident.sweep.studies import StudyResult, row


def answers(
    named: Mapping[str, Any], answer: Callable[[Any], Any], folder: Path, progress: Callable[[float], None]
) -> dict[str, Any]:
    """Name -> answer to what is named, as JSON holds it; what `folder` has of them is not asked again.

    answer   a function of a module, called in other processes
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = {name: folder / f"{name}.json" for name in named}
    with workers_with(nullcontext) as workers:
        jobs = [workers.submit(_kept, answer, asked, files[name]) for name, asked in named.items()]
        for number, job in enumerate(as_completed(jobs), start=1):
            job.result()
            progress(number / len(jobs))
    return {name: json.loads(file.read_text()) for name, file in files.items()}


def _kept(_: None, answer: Callable[[Any], Any], asked: Any, file: Path) -> None:
    if file.exists():
        return
    with threadpool_limits(1):
        said = answer(asked)
    with replacing(file) as path:
        path.write_text(json.dumps(said))


def reported(
    file: Path, usual: Mapping[str, str], lines: Iterable[Mapping[str, str]], name: str = "{threshold}"
) -> StudyResult:
    """The row of the rules as they are, then one per threshold; the lines as a table in `file`.

    name   of a row, with columns of its line
    """
    listed = list(lines)
    with replacing(file) as path:
        pd.DataFrame(listed).to_csv(path, index=False)
    rows = [row(name.format(**v), f"half: {v['half']}; twice: {v['twice']}") for v in listed]
    return StudyResult([dict(usual), *rows], [file])
