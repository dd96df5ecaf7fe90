"""What a plan will take, before it is begun."""

import time
from pathlib import Path

from flexmodels.cores import cores
from pyident.sweep.plan import load_study_plan
from pyident.sweep.run import one_run

MANY = 20_000  # runs from which a plan is worth a question


def seconds_of(path: str | Path, runs: int, workers: int | None = None) -> float:
    """Estimated time [s] of a plan's runs on this machine, from one run of its model. Raises as `one_run`."""
    plan = load_study_plan(path, most=1)
    begin = time.perf_counter()
    once = one_run(plan)
    overhead = time.perf_counter() - begin - once
    return overhead + runs * once / (workers or cores())


def in_words(seconds: float) -> str:
    """A duration as one says it."""
    for unit, size in (("days", 86_400.0), ("hours", 3_600.0), ("minutes", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"
