"""Work shared out among threads that all end before the caller goes on."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from flexmodels.cores import cores

T = TypeVar("T")
R = TypeVar("R")


def gathered(
    work: Callable[[T], R], items: Iterable[T], failed: Callable[[], None] = lambda: None
) -> list[R]:
    """work(item) of every item in their order, on all cores; `work` may itself share out work.

    failed   called when a work has failed or the caller is interrupted, before the others are waited for
    Raises what `work` raises; what has not begun by then does not begin.
    """
    listed = list(items)
    if min(cores(), len(listed)) <= 1:
        return [work(item) for item in listed]
    with ThreadPoolExecutor(min(cores(), len(listed))) as threads:
        jobs = [threads.submit(work, item) for item in listed]
        try:
            return [job.result() for job in jobs]
        except BaseException:
            failed()
            for job in jobs:
                job.cancel()
            raise
