"""What every command shares: its options, its progress bar, and how bad input ends."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any

import click
from rich.console import Console
from rich.progress import Progress

from flexfmu.build import BuildError
from flexmodels.atomic import replacing
from flexmodels.inputs import SimulationError
from flexmodels.robot import RobotError
from pyident.logs.log import LogError
from pyident.simulation.references import ExperimentError
from pyident.simulation.workers import WorkersError
from pyident.sweep.store import StudyError

console = Console()
_BAD_INPUT = (RobotError, LogError, ExperimentError, SimulationError, BuildError, StudyError, WorkersError)


def reported(command: Callable[..., Any]) -> Callable[..., Any]:
    """Bad input ends in one sentence and exit code 2; Ctrl-C in 130."""

    @wraps(command)
    def run(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except _BAD_INPUT as error:
            click.echo(f"error: {error}", err=True)
            sys.exit(2)
        except OSError as error:
            click.echo(f"error: {error.filename}: {error.strerror}", err=True)
            sys.exit(2)
        except KeyboardInterrupt:
            click.echo("stopped", err=True)
            sys.exit(130)

    return run


@contextmanager
def progress_bar(text: str) -> Iterator[Callable[[float], None]]:
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)


def write_json(path: str | None, content: Any) -> None:
    if path:
        with replacing(path) as file:
            file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


json_option = click.option("--json", "json_file", metavar="FILE", help="Write the result for machines.")
output_option = click.option(
    "-o", "--output", required=True, type=click.Path(dir_okay=False), help="File to write."
)
