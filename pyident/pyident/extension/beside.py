"""Work that goes on beside the caller's own."""

from collections.abc import Callable
from concurrent.futures import Future
from contextvars import copy_context
from threading import Thread
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def begun(work: Callable[P, R], *arguments: P.args, **named: P.kwargs) -> "Future[R]":
    """Call work in a thread that sees the caller's context, such as the processes that are kept for it.

    Nobody waits for the thread but who asks for its result: an interrupt leaves it to end with its processes.
    """
    future: Future[R] = Future()

    def do() -> None:
        try:
            future.set_result(work(*arguments, **named))
        except BaseException as error:
            future.set_exception(error)

    Thread(target=copy_context().run, args=(do,), daemon=True).start()
    return future
