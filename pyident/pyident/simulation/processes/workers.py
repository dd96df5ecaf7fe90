"""Processes that each hold a tool: those of a Dask cluster where one is configured, else this machine's own.

Both are executors of concurrent.futures. The tool goes to every process once; a task has only its arguments.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import TypeVar

from pyident.simulation.processes.dask_cluster import configured_scheduler, dask_workers
from pyident.simulation.processes.this_machine import local_processes
from pyident.simulation.processes.tools import Make, Processes

T = TypeVar("T")


@contextmanager
def workers_with(
    make: Make[T], on_this_machine: "Callable[[Make[T]], AbstractContextManager[Processes[T]]] | None" = None
) -> Iterator[Processes[T]]:
    """The Dask cluster that is configured (DASK_SCHEDULER_ADDRESS), else processes of this machine."""
    scheduler = configured_scheduler()
    own = on_this_machine or local_processes
    with dask_workers(make, scheduler) if scheduler else own(make) as workers:
        yield workers
