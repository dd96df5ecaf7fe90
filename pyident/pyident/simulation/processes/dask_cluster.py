"""A Dask cluster, on this machine or elsewhere, whose workers keep a tool."""

import time
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from logging import CRITICAL
from multiprocessing import active_children
from pathlib import Path
from typing import Any, TypeVar

from flexmodels.cores import cores
from flexmodels.scratch import scratch_folder
from pyident.simulation.processes.process_ends import interrupts_blocked
from pyident.simulation.processes.this_machine import ignore_interrupts
from pyident.simulation.processes.tools import Make, Processes, install, remove

T = TypeVar("T")

_CONNECT_SECONDS = 15
_START_SECONDS = 120  # of a worker on this machine, however loaded
_MISSING = "Dask is missing, which runs parameter studies; pip install 'flexident[study]'"


class WorkersError(RuntimeError):
    """No processes to work with; the message names the cure."""


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
        """Waits for the workers and gives each its tool; one that replaces a dead worker gets it too.

        Raises WorkersError.
        """
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
            count = count or cores()
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

    asked = {
        "distributed.scheduler.allowed-failures": 1,
        # The cluster drops a worker for good whose successor takes longer, and then waits for none for ever.
        "distributed.deploy.lost-worker-timeout": f"{_START_SECONDS}s",
        "temporary-directory": str(folder),
    }
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
            install(token, make)

        def teardown(self, worker: Any) -> None:
            remove(token)

    return Tool()


def _deaf_plugin() -> Any:
    from distributed import WorkerPlugin

    class Deaf(WorkerPlugin):
        """Ctrl-C goes to every process of the terminal; the one that started the others stops them."""

        def setup(self, worker: Any) -> None:
            ignore_interrupts()

    return Deaf()
