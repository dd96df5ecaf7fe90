"""Processes of this machine, one per core, which start when they are first needed."""

import pickle
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures import wait as wait_for
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from multiprocessing import get_context
from typing import Any, TypeVar
from weakref import WeakSet

from flexmodels.cores import cores
from flexmodels.scratch import scratch_folder
from pyident.simulation.processes.process_ends import end_with_parent, interrupts_blocked, not_run_again
from pyident.simulation.processes.tools import Make, Processes, remove_all

R = TypeVar("R")
T = TypeVar("T")


class _Pool(ProcessPoolExecutor):
    """Tasks start the processes, which are not to see Ctrl-C nor to run the caller's script."""

    def __init__(self, count: int):
        super().__init__(count, mp_context=get_context("spawn"), initializer=_start_process)
        self.count, self.begun = count, False
        self._preparing: list[Future[Any]] = []

    def prepare(self, module: str) -> None:
        """Start every process now and let it import a module."""
        self._preparing = [self.submit(import_module, module) for _ in range(self.count)]

    @property
    def ready(self) -> bool:
        """Whether its processes have been started, and have prepared themselves where they were to."""
        return self.begun and all(future.done() for future in self._preparing)

    def submit(self, fn: Callable[..., R], /, *args: Any, **kwargs: Any) -> "Future[R]":
        self.begun = True
        with interrupts_blocked(), not_run_again():
            return super().submit(fn, *args, **kwargs)


class _Share(Executor):
    """One caller's tasks for processes that may have others."""

    def __init__(self, pool: _Pool):
        self._pool, self._asked = pool, WeakSet[Future[Any]]()

    def submit(self, fn: Callable[..., R], /, *args: Any, **kwargs: Any) -> "Future[R]":
        future = self._pool.submit(fn, *args, **kwargs)
        self._asked.add(future)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        asked = list(self._asked)
        if cancel_futures:
            for future in asked:
                future.cancel()
        if wait:
            wait_for(asked)


_kept: ContextVar[_Pool | None] = ContextVar("processes that work for every caller in a block", default=None)


@contextmanager
def processes_kept(module: str | None = None) -> Iterator[None]:
    """What asks for local processes in the block gets the same ones: they start, and import, once.

    module   where the work is long: they start at once, and import this one, while this process goes on
    """
    kept = _kept.get()
    if kept is not None:
        if module is not None:
            kept.prepare(module)
        yield
        return
    with _new_pool() as pool:
        before = _kept.set(pool)
        try:
            if module is not None:
                pool.prepare(module)
            yield
        finally:
            _kept.reset(before)


def processes_ready() -> bool:
    """Whether local processes wait for this caller's work."""
    pool = _kept.get()
    return pool is not None and pool.ready


@contextmanager
def local_processes(make: Make[T]) -> Iterator[Processes[T]]:
    """One process per core; `make` builds the tool and reaches them by pickle, in a file.

    What is sent to a process at its start would hold up the start of the next until it is read.
    """
    pool = _kept.get()
    if pool is None:
        with processes_kept(), local_processes(make) as workers:
            yield workers
        return
    with scratch_folder() as folder:
        file = folder / "tool.pickle"
        file.write_bytes(pickle.dumps(make))
        share = _Share(pool)
        try:
            yield Processes(share, pool.count, str(file))
        finally:
            share.shutdown(cancel_futures=True)


@contextmanager
def _new_pool() -> Iterator[_Pool]:
    pool = _Pool(cores())
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _start_process() -> None:
    ignore_interrupts()
    end_with_parent(remove_all)


def ignore_interrupts() -> None:
    """Ctrl-C goes to every process of the terminal; the one that started the others stops them."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
