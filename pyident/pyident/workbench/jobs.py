"""Long work in a process of its own: it reports progress, can be cancelled, and never blocks the page."""

import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, Literal

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
        context = get_context("spawn")
        self._receiver, sender = context.Pipe(duplex=False)
        self._process = context.Process(target=_run, args=(sender, work, arguments))
        self._process.start()
        sender.close()
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def running(self) -> bool:
        return self.state == "running"

    def cancel(self) -> None:
        """Stop it and the processes that it started; what it wrote is whole files or nothing."""
        if self.running:
            self.state = "cancelled"
            _stop(self._process.pid)

    def wait(self, seconds: float | None = None) -> None:
        """Return when it has ended, or after so many seconds."""
        self._listener.join(seconds)

    def _listen(self) -> None:
        try:
            while self.running:
                kind, value = self._receiver.recv()
                if kind == "progress":
                    self.progress = float(value)
                elif kind == "result":
                    self.result, self.state, self.progress = value, "done", 1.0
                else:
                    self.error, self.state = str(value), "failed"
        except (EOFError, OSError):
            if self.running:
                self.error, self.state = "the process ended without a word", "failed"
        self._process.join()


def _run(sender: Connection, work: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    if hasattr(os, "setsid"):
        os.setsid()  # so that cancelling reaches the processes that this one starts
    last = 0.0

    def progress(fraction: float) -> None:
        nonlocal last
        if fraction - last >= 0.005 or fraction >= 1.0:
            last = fraction
            sender.send(("progress", fraction))

    try:
        sender.send(("result", work(*arguments, progress=progress)))
    except (ValueError, RuntimeError, OSError, ImportError) as error:
        traceback.print_exc(file=sys.stderr)
        sender.send(("error", str(error) or type(error).__name__))
    except Exception as error:
        traceback.print_exc(file=sys.stderr)
        sender.send(("error", f"fault in pyident itself, please report it ({type(error).__name__}: {error})"))


def _stop(pid: int | None) -> None:
    if pid is None:
        return
    try:
        if hasattr(os, "killpg"):
            os.killpg(pid, signal.SIGTERM)
        else:
            os.kill(pid, signal.SIGTERM)
    except ProcessLookupError:
        pass  # it has ended meanwhile
