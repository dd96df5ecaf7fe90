"""Samples shared out among the cores; threads, for what works outside of Python (C, NumPy, LAPACK)."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

T = TypeVar("T")


def spread(work: Callable[[slice], None], samples: int, most: int) -> None:
    """work(part) for parts of at most `most` samples that make up the whole, on all cores.

    Raises what `work` raises.
    """
    parts = [slice(at, min(at + most, samples)) for at in range(0, samples, most)]
    each(work, parts)


def each(work: Callable[[T], None], items: Iterable[T]) -> None:
    """work(item) for every item, on all cores. Raises what `work` raises."""
    if cores() == 1:
        for item in items:
            work(item)
    else:
        list(_threads().map(work, items))


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(cores())
