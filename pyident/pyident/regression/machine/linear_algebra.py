"""Products and factors of matrices in one thread each, as logs, coordinates and runs share out the cores.

Threads of BLAS beside ours wait for each other in loops: they took as much time of the processors as all
else. In one thread sums also come out the same on machines with more cores.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from threadpoolctl import threadpool_limits


@dataclass
class _Limit:
    """Of the whole process: whoever comes first sets it, the last one to leave takes it away again.

    Builds of OpenBLAS are known that follow only their main thread when they get threads back: there a last
    one that leaves in another thread leaves the limit of one.
    """

    lock: threading.Lock = field(default_factory=threading.Lock)
    users: int = 0
    set_by_first: threadpool_limits | None = None


_limit = _Limit()


@contextmanager
def one_thread() -> Iterator[None]:
    """For a block or, as a decorator, a function: BLAS and LAPACK take one thread for each call."""
    import scipy.linalg  # noqa: F401  (a limit reaches what is loaded)

    with _limit.lock:
        if not _limit.users:
            _limit.set_by_first = threadpool_limits(1)
        _limit.users += 1
    try:
        yield
    finally:
        with _limit.lock:
            _limit.users -= 1
            if not _limit.users and _limit.set_by_first:
                _limit.set_by_first.restore_original_limits()
