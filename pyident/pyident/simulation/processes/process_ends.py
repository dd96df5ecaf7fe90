"""How processes begin and end: without the caller's script, with their parent, by no Ctrl-C of another's."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import parent_process, resource_tracker
from multiprocessing.connection import wait

_one_at_a_time = threading.RLock()
_TOLD_BY = ("__file__", "__spec__")  # by which `multiprocessing` finds what a new process is to run first


def end_with_parent(clean_up: Callable[[], None]) -> None:
    """Watch the process that started this one; when it is gone, however it ended, clean up and end too."""
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_watch, args=(parent.sentinel, clean_up), daemon=True).start()


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """A process or thread that is started in the block never sees Ctrl-C; this one sees it afterwards.

    The tracker of shared resources, which the first process brings along, unblocks Ctrl-C in the thread
    that starts it, so it is started before.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def not_run_again() -> Iterator[None]:
    """Processes that are spawned in the block do not run the caller's script.

    Else one without `if __name__ == "__main__":` would call this package in every process again, and hang.
    What is sent to them must come from modules.
    """
    known = vars(sys.modules["__main__"])
    with _one_at_a_time:
        kept = {name: known[name] for name in _TOLD_BY if name in known}
        known.update(dict.fromkeys(kept))
        try:
            yield
        finally:
            known.update(kept)


def _watch(sentinel: int, clean_up: Callable[[], None]) -> None:
    wait([sentinel])
    with suppress(Exception):
        clean_up()
    os._exit(1)
