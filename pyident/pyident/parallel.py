"""Samples shared out among the cores; threads, for what works outside of Python (C, NumPy, LAPACK)."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache


def spread(work: Callable[[slice], None], samples: int, most: int) -> None:
    """work(part) for parts of at most `most` samples that make up the whole, on all cores.

    Raises what `work` raises.
    """
    parts = [slice(at, min(at + most, samples)) for at in range(0, samples, most)]
    if cores() == 1 or len(parts) == 1:
        for part in parts:
            work(part)
    else:
        list(_threads().map(work, parts))


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(cores())
