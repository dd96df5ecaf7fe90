"""Samples shared out among the cores; threads, for what works outside of Python (C, NumPy, LAPACK)."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

from flexmodels.cores import cores

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


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(cores())
