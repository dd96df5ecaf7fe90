"""A process for long work that stays for the next: what it has imported, and processes of its own, are there.

One of them waits; others end. What it starts belongs to its group, so that stopping it reaches all.
"""

import atexit
import os
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from pyident.simulation.processes.this_machine import processes_kept

Serve = Callable[[Connection], None]


@dataclass(frozen=True)
class WarmProcess:
    """link: to what it serves."""

    process: SpawnProcess
    link: Connection

    def stop(self) -> None:
        """End it and the processes that it started; who reads its link finds the end of it."""
        assert self.process.pid is not None  # it was started
        try:
            os.killpg(self.process.pid, signal.SIGTERM)
        except (AttributeError, ProcessLookupError):  # Windows; or it has no group yet, or has ended
            self.process.terminate()

    def dismiss(self) -> None:
        """Let it end, for it waits for work."""
        self.link.close()


_waiting: list[WarmProcess] = []  # one at most
_one_at_a_time = threading.Lock()


def taken(serve: Serve) -> WarmProcess:
    """The process that waits, if there is one, else a new one that calls `serve(link)`."""
    with _one_at_a_time:
        while _waiting:
            found = _waiting.pop()
            if found.process.is_alive():
                return found
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, serve))
    process.start()
    theirs.close()
    return WarmProcess(process, ours)


def given_back(process: WarmProcess) -> None:
    """It waits for the next work, unless another one does."""
    with _one_at_a_time:
        if _waiting or not process.process.is_alive():
            process.dismiss()
        else:
            _waiting.append(process)


@atexit.register  # before multiprocessing waits for its processes
def dismiss_all() -> None:
    """Let what waits end."""
    with _one_at_a_time:
        while _waiting:
            _waiting.pop().dismiss()


def _serve(link: Connection, serve: Serve) -> None:
    if hasattr(os, "setsid"):
        os.setsid()
    with processes_kept():
        serve(link)
