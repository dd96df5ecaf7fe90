"""Parts of work in threads, with one progress: when one fails or the caller is interrupted, all end."""

from collections.abc import Callable, Sequence
from threading import Event, Lock
from typing import TypeVar

from flexmodels.threads import gathered

T = TypeVar("T")
R = TypeVar("R")
Progress = Callable[[float], None]


class Stopped(Exception):
    """Raised out of a part's progress when another part has failed."""


def in_threads(
    work: Callable[[Sequence[T], Progress], R], parts: Sequence[Sequence[T]], progress: Progress
) -> list[R]:
    """work(part, progress of the part) for every part, in their order; it should call its progress often.

    progress   called with the fraction done of all, by one thread at a time
    Raises what the first part raised that failed.
    """
    done, total = [0.0] * len(parts), sum(len(part) for part in parts)
    ended, lock = Event(), Lock()

    def one(number: int) -> R:
        def told(share: float) -> None:
            if ended.is_set():
                raise Stopped
            with lock:
                done[number] = share * len(parts[number]) / total
                progress(sum(done))

        return work(parts[number], told)

    return gathered(one, range(len(parts)), ended.set)
