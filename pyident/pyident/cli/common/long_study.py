"""A study that would take very long is begun only when its user knows."""

import click

from pyident.cli.common.shared import show
from pyident.sweep.cost import MANY, in_words, seconds_of
from pyident.sweep.plan import planned_runs
from pyident.sweep.store import StudyError


def ask_first(plan: str, workers: int | None, yes: bool) -> None:
    """Say what a plan of very many runs will take, and ask. Raises StudyError when the answer is no."""
    runs = planned_runs(plan)
    if runs <= MANY or yes:
        return
    show(f"{plan}: {runs} runs would take about {in_words(seconds_of(plan, runs, workers))} on this machine")
    try:
        click.confirm("Begin?", abort=True)
    except click.Abort:
        raise StudyError(f"{plan}: not begun; plan fewer runs, or pass --yes") from None
