"""Simulations of one robot: here as long as that is sooner over than other processes are started."""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Concatenate, ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

from pyident.simulation.processes.this_machine import local_processes, processes_ready
from pyident.simulation.processes.tools import Make, Processes, inline
from pyident.simulation.processes.workers import workers_with

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")

_START = 4.0  # s of computing that a process takes before its first task: it imports all that this one has


@dataclass(frozen=True)
class _Growing(Processes[T]):
    """Tasks are done by `here` at once until others are ready, or would have been started as soon."""

    here: Processes[T]
    taken: list[float] = field(default_factory=list)

    def submit(
        self, work: Callable[Concatenate[T, P], R], *arguments: P.args, **named: P.kwargs
    ) -> "Future[R]":
        if processes_ready() or sum(self.taken) >= _START:
            return super().submit(work, *arguments, **named)
        begin = time.process_time()
        try:
            with threadpool_limits(1):  # as in the others, so that sums come out the same
                return self.here.submit(work, *arguments, **named)
        finally:
            self.taken.append(time.process_time() - begin)


@contextmanager
def growing_pool(make: Make[T]) -> Iterator[Processes[T]]:
    """The Dask cluster that is configured; else this process, and one per core where the work goes on."""
    with workers_with(make, _growing) as workers:
        yield workers


@contextmanager
def _growing(make: Make[T]) -> Iterator[Processes[T]]:
    with inline(make) as here, local_processes(make) as others:
        yield _Growing(others.executor, others.count, others.token, here)
