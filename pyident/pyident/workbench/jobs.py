"""Long work in a process of its own: it reports progress, can be cancelled, and never blocks the page."""

import sys
import threading
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, Literal

from pyident.simulation.processes.warm_process import given_back, taken

State = Literal["running", "done", "failed", "cancelled"]


class Job:
    """One call `work(*arguments, progress=...)` in another process.

    work   a function of a module, for it is sent by name;  title: in words, for the page
    Its result or the sentence of its failure is read with `result` and `error` once `state` says so.
    """

    def __init__(self, title: str, work: Callable[..., Any], *arguments: Any):
        self.title = title
        self.progress = 0.0
        self.state: State = "running"
        self.result: Any = None
        self.error = ""
        self._ends = threading.Lock()
        self._process = taken(_every_job)
        self._listener = threading.Thread(target=self._listen, args=(work, arguments), daemon=True)
        self._listener.start()

    @property
    def running(self) -> bool:
        return self.state == "running"

    def cancel(self) -> None:
        """Stop it and the processes that it started; what it wrote is whole files or nothing."""
        with self._ends:
            if self.running:
                self.state = "cancelled"
                self._process.stop()

    def wait(self, seconds: float | None = None) -> None:
        """Return when it has ended, or after so many seconds."""
        self._listener.join(seconds)

    def _listen(self, work: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        try:
            self._process.link.send((work, arguments))
            kind, value = self._process.link.recv()
            while kind == "progress":
                self.progress = float(value)
                kind, value = self._process.link.recv()
        except (EOFError, OSError):
            kind, value = "end", "the process ended without a word"
        with self._ends:
            if kind == "end" or not self.running:
                self._process.stop()
                self._process.dismiss()
            else:
                given_back(self._process)  # before anybody sees that it is free
            if not self.running:  # it was cancelled
                return
            if kind == "result":
                self.result, self.progress, self.state = value, 1.0, "done"
            else:
                self.error, self.state = str(value), "failed"


def _every_job(link: Connection) -> None:
    """One job after the other, in their process."""
    while True:
        try:
            work, arguments = link.recv()
        except (EOFError, OSError):
            return
        _do(link, work, arguments)


def _do(link: Connection, work: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    last = 0.0

    def progress(fraction: float) -> None:
        nonlocal last
        if fraction - last >= 0.005 or fraction >= 1.0:
            last = fraction
            link.send(("progress", fraction))

    try:
        link.send(("result", work(*arguments, progress=progress)))
    except (ValueError, RuntimeError, OSError, ImportError) as error:
        traceback.print_exc(file=sys.stderr)
        link.send(("error", str(error) or type(error).__name__))
    except Exception as error:
        traceback.print_exc(file=sys.stderr)
        link.send(("error", f"fault in pyident itself, please report it ({type(error).__name__}: {error})"))
