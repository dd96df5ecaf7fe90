"""Progress for who does not look at a terminal: a line every ten seconds."""

import time
from collections.abc import Callable

import click

SECONDS = 10.0


def lines(text: str, clock: Callable[[], float] = time.monotonic) -> Callable[[float], None]:
    """Says on stderr what is being done, how much of it is done and about how long the rest takes."""
    begin = said = clock()

    def progress(fraction: float) -> None:
        nonlocal said
        now = clock()
        if now - said < SECONDS:
            return
        said = now
        left = (now - begin) * (1 - fraction) / fraction if fraction > 0 else float("nan")
        rest = f", about {left:.0f} s left" if left == left else ""
        click.echo(f"{text}: {100 * fraction:.0f} % after {now - begin:.0f} s{rest}", err=True)

    return progress
