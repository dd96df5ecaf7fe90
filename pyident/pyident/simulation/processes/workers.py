"""Processes that each hold a tool, such as a loaded FMU: this machine's own, or those of a Dask cluster.

Both are executors of concurrent.futures. The tool goes to every process once; a task has only its arguments.
"""

import signal
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from logging import CRITICAL
from multiprocessing import active_children, get_context
from os import cpu_count
from pathlib import Path
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

from flexmodels.scratch import scratch_folder
from pyident.simulation.processes.process_ends import end_with_parent, interrupts_blocked, not_run_again

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
Make = Callable[[], AbstractContextManager[T]]

_CONNECT_SECONDS = 15
_START_SECONDS = 120  # of a worker on this machine, however loaded
_MISSING = "Dask is missing, which runs parameter studies; pip install 'flexident[study]'"


class WorkersError(RuntimeError):
    """No processes to work with; the message names the cure."""


@dataclass(frozen=True)
class Processes(Generic[T]):
    """executor: where tasks go; count: of processes; token: under which they keep their tool."""

    executor: Executor
    count: int
    token: str

    def submit(
        self, work: Callable[Concatenate[T, P], R], *arguments: P.args, **named: P.kwargs
    ) -> "Future[R]":
        """Call `work(tool, *arguments)` in one of the processes. The tool serves one call at a time."""
        return self.executor.submit(_with_tool, self.token, work, *arguments, **named)


@contextmanager
def workers_with(
    make: Make[T], on_this_machine: "Callable[[Make[T]], AbstractContextManager[Processes[T]]] | None" = None
) -> Iterator[Processes[T]]:
    """The Dask cluster that is configured (DASK_SCHEDULER_ADDRESS), else processes of this machine."""
    scheduler = configured_scheduler()
    own = on_this_machine or local_processes
    with dask_workers(make, scheduler) if scheduler else own(make) as workers:
        yield workers


class _Pool(ProcessPoolExecutor):
    """The first tasks start the processes, which are not to see Ctrl-C nor to run the caller's script."""

    def submit(self, fn: Callable[..., R], /, *args: Any, **kwargs: Any) -> "Future[R]":
        with interrupts_blocked(), not_run_again():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def local_processes(make: Make[T]) -> Iterator[Processes[T]]:
    """One process per core, started when first needed; `make` builds the tool and is sent by pickle."""
    token, count = uuid.uuid4().hex, cpu_count() or 1
    pool = _Pool(count, mp_context=get_context("spawn"), initializer=_start_process, initargs=(token, make))
    try:
        yield Processes(pool, count, token)
    finally:
        pool.shutdown(cancel_futures=True)


class _Here(Executor):
    """Does at once, in this process, what it is given."""

    def submit(self, fn: Callable[..., R], /, *args: Any, **kwargs: Any) -> "Future[R]":
        future: Future[R] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def inline(make: Make[T]) -> Iterator[Processes[T]]:
    """No other process: for work that is shorter than the start of one, and for tests."""
    token = uuid.uuid4().hex
    _install(token, make)
    try:
        yield Processes(_Here(), 1, token)
    finally:
        _remove(token)


@contextmanager
def dask_workers(make: Make[T], scheduler: str | None = None) -> Iterator[Processes[T]]:
    """The workers of the cluster at `scheduler`, else one per core of this machine, with their tool."""
    with dask_cluster(scheduler) as cluster, cluster.holding(make) as workers:
        yield workers


@dataclass(frozen=True)
class Cluster:
    """client: of Dask; count: of workers, some of which may still be starting."""

    client: Any
    count: int

    @contextmanager
    def holding(self, make: Make[T]) -> Iterator[Processes[T]]:
        """Waits for the workers and gives each its tool; one that replaces a dead worker gets it too."""
        token = uuid.uuid4().hex
        try:
            self.client.wait_for_workers(self.count, timeout=_START_SECONDS)
        except TimeoutError:
            raise WorkersError(
                f"{self.count} workers did not start within {_START_SECONDS} s; ask for fewer"
            ) from None
        try:
            self.client.register_plugin(_tool_plugin(token, make), name=token)
        except ImportError as error:
            address = self.client.scheduler.address
            raise WorkersError(
                f"the workers of {address} cannot run this ({error}); install flexident there"
            ) from None
        executor = self.client.get_executor(pure=False)
        try:
            yield Processes(executor, self.count, token)
        finally:
            executor.shutdown(wait=False)
            self.client.unregister_worker_plugin(token)


@contextmanager
def dask_cluster(
    scheduler: str | None = None, count: int | None = None, module: str | None = None
) -> Iterator[Cluster]:
    """The cluster at `scheduler`, or `count` (all cores) Dask workers of this machine.

    The latter start while the caller goes on, and import `module` at once. Raises WorkersError.
    """
    if find_spec("distributed") is None:
        raise WorkersError(_MISSING)
    from distributed import Client

    if scheduler is None:
        with scratch_folder() as folder, _local_cluster(module, folder) as local, Client(local) as client:
            client.register_plugin(_deaf_plugin(), name="deaf")
            count = count or cpu_count() or 1
            _start(local, count)
            yield Cluster(client, count)
        return
    try:
        client = Client(scheduler, timeout=_CONNECT_SECONDS)
        client.wait_for_workers(1, timeout=_CONNECT_SECONDS)
    except (OSError, ValueError) as error:
        raise WorkersError(
            f"no Dask scheduler with workers answers at {scheduler} ({type(error).__name__}); "
            "start one with `dask scheduler` and `dask worker`"
        ) from None
    with client:
        yield Cluster(client, len(client.nthreads()))  # pyright: ignore[reportArgumentType]


def configured_scheduler() -> str | None:
    """The scheduler's address in Dask's configuration, None without it or without Dask."""
    if find_spec("distributed") is None:
        return None
    import dask.config

    return dask.config.get("scheduler-address", None)


@contextmanager
def scheduler_configured(address: str | None) -> Iterator[None]:
    """Let `address` be what `configured_scheduler` says, unless it is None. Raises WorkersError."""
    if address is None:
        yield
        return
    if find_spec("distributed") is None:
        raise WorkersError(_MISSING)
    import dask.config

    with dask.config.set({"scheduler-address": address}):
        yield


@contextmanager
def _local_cluster(module: str | None, folder: Path) -> Iterator[Any]:
    """No workers yet; theirs and the scheduler's is `folder`, which goes even when this process is killed."""
    import dask.config
    from distributed import LocalCluster

    asked = {"distributed.scheduler.allowed-failures": 1, "temporary-directory": str(folder)}
    with dask.config.set(asked), ExitStack() as open_ones:
        with interrupts_blocked():  # one that is half built cannot be closed
            cluster = LocalCluster(
                n_workers=0,
                threads_per_worker=1,
                local_directory=str(folder),
                dashboard_address=":0",
                memory_limit=0,  # pyright: ignore[reportArgumentType]
                silence_logs=CRITICAL,
                preload=[module] if module else [],
            )
            open_ones.enter_context(cluster)
        yield cluster


def _start(local: Any, count: int) -> None:
    """Returns when the processes are there, though not yet at work.

    A process takes over this one's working directory, which changes for a moment while an FMU is loaded.
    """
    others, end = len(active_children()), time.monotonic() + _START_SECONDS
    local.scale(count)
    while len(active_children()) < others + count and time.monotonic() < end:
        time.sleep(0.01)


def _tool_plugin(token: str, make: Make[Any]) -> Any:
    from distributed import WorkerPlugin

    class Tool(WorkerPlugin):
        """Builds the tool in every worker, those that join later included."""

        def setup(self, worker: Any) -> None:
            _install(token, make)

        def teardown(self, worker: Any) -> None:
            _remove(token)

    return Tool()


def _deaf_plugin() -> Any:
    from distributed import WorkerPlugin

    class Deaf(WorkerPlugin):
        """Ctrl-C goes to every process of the terminal; the one that started the others stops them."""

        def setup(self, worker: Any) -> None:
            _ignore_interrupts()

    return Deaf()


_tools: dict[str, tuple[AbstractContextManager[Any], Any]] = {}  # the worker process's own
_one_at_a_time = threading.RLock()  # a task that runs inline may have begun in another


def _start_process(token: str, make: Make[Any]) -> None:
    _ignore_interrupts()
    end_with_parent(partial(_remove, token))
    _install(token, make)
    threadpool_limits(1)  # a process per core: more threads would only wait for each other


def _ignore_interrupts() -> None:
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _install(token: str, make: Make[Any]) -> None:
    manager = make()
    _tools[token] = manager, manager.__enter__()


def _remove(token: str) -> None:
    if token in _tools:
        _tools.pop(token)[0].__exit__(None, None, None)


def _with_tool(token: str, work: Callable[..., R], *arguments: Any, **named: Any) -> R:
    with _one_at_a_time:
        return work(_tools[token][1], *arguments, **named)
