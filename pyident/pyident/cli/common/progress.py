"""Progress for who does not look at a terminal: a line every ten seconds."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Lock, Thread

import click

Tell = Callable[[float], None]
SECONDS = 10.0
_FIRST = 0.05  # of the work: less is preparation
_ENOUGH = 0.25  # of the work, that tells about the rest: shares of work are not shares of time


def lines(text: str, clock: Callable[[], float] = time.monotonic) -> Tell:
    """Says on stderr what is being done, how much of it is done and about how long the rest takes.

    What came before a first share of next to nothing, such as compiling, tells nothing about the rest. Nor
    does little of the work, nor a step that lasts longer than all the rest was to take: then no time is said.
    """
    begin = said = clock()
    first: tuple[float, float] | None = None
    reached = (begin, 0.0)

    def progress(fraction: float) -> None:
        nonlocal said, first, reached
        now = clock()
        first = first or ((now, fraction) if fraction < _FIRST else (begin, 0.0))
        if fraction != reached[1]:
            reached = now, fraction
        if now - said < SECONDS:
            return
        said = now
        took, done = reached[0] - first[0], fraction - first[1]
        left = took * (1 - fraction) / done - (now - reached[0]) if fraction >= _ENOUGH else -1.0
        rest = f", about {left:.0f} s left" if left >= 0 else ""
        click.echo(f"{text}: {100 * fraction:.0f} % after {now - begin:.0f} s{rest}", err=True)

    return progress


@contextmanager
def repeated(
    progress: Callable[[float], None], every: float = SECONDS / 5
) -> Iterator[Callable[[float], None]]:
    """The same progress, which is told its last share again and again [s] while a step of the work lasts."""
    last: list[float] = []
    over, one = Event(), Lock()

    def told(fraction: float) -> None:
        with one:
            last[:] = [fraction]
            progress(fraction)

    def again() -> None:
        while not over.wait(every):
            with one:
                for fraction in last:
                    progress(fraction)

    beat = Thread(target=again, daemon=True)
    beat.start()
    try:
        yield told
    finally:
        over.set()
        beat.join()
