"""Tools that tasks work with, such as a loaded FMU: each process builds one once and knows it by a token."""

import pickle
import threading
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
Make = Callable[[], AbstractContextManager[T]]


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
        return self.executor.submit(with_tool, self.token, work, *arguments, **named)


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
    install(token, make)
    try:
        yield Processes(_Here(), 1, token)
    finally:
        remove(token)


_tools: dict[str, tuple[AbstractContextManager[Any], Any]] = {}  # this process's own
_fetched: set[str] = set()  # tokens of those that came as files
_one_at_a_time = threading.RLock()  # a task that runs inline may have begun in another


def install(token: str, make: Make[Any]) -> None:
    """Build a tool in this process."""
    manager = make()
    _tools[token] = manager, manager.__enter__()


def remove(token: str) -> None:
    """Put a tool away, if there is one."""
    if token in _tools:
        _tools.pop(token)[0].__exit__(None, None, None)


def remove_all() -> None:
    """Put every tool away, at the end of this process."""
    for token in list(_tools):
        remove(token)


def with_tool(token: str, work: Callable[..., R], *arguments: Any, **named: Any) -> R:
    """Call `work(tool, *arguments)`. A token that is not known yet is the path of a pickled `make`."""
    with _one_at_a_time:
        if token not in _tools:
            _fetch(token)
        return work(_tools[token][1], *arguments, **named)


def _fetch(token: str) -> None:
    """Build the tool of a file, and put away those whose file is gone: nobody asks for them any more."""
    for old in [t for t in _fetched if not Path(t).exists()]:
        _fetched.remove(old)
        remove(old)
    install(token, pickle.loads(Path(token).read_bytes()))
    _fetched.add(token)
    threadpool_limits(1)  # a process per core: more threads would only wait for each other
