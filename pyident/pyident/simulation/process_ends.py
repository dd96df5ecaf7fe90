"""How processes end: a worker with its parent, and none by a Ctrl-C that is meant for another."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import parent_process, resource_tracker
from multiprocessing.connection import wait


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


def _watch(sentinel: int, clean_up: Callable[[], None]) -> None:
    wait([sentinel])
    with suppress(Exception):
        clean_up()
    os._exit(1)
