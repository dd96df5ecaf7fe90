"""What every command shares: its options, its progress bar, and how bad input ends.

What is shown may come from files: it is never read as markup, and what would steer a terminal is escaped.
"""

import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, NoReturn, TypeVar

import click
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from flexmodels.atomic import replacing
from pyident.cli.common.outputs import JSON, OVERWRITE, Kind, Output, check_outputs
from pyident.cli.common.progress import lines, repeated

Command = TypeVar("Command", bound=Callable[..., Any])

console = Console(markup=False, emoji=False, highlight=False)
_STOPPED = 130
_OUR_FAULT = 70  # as sysexits.h has it


def reported(command: Callable[..., Any]) -> Callable[..., Any]:
    """Bad input ends in one sentence and exit code 2, a fault of ours in one and 70, Ctrl-C in 130."""

    @wraps(command)
    def run(*args: Any, **kwargs: Any) -> Any:
        try:
            check_outputs(click.get_current_context())
            return command(*args, **kwargs)
        except OSError as error:
            ended(f"error: {reason(error)}", 2)
        except MemoryError:
            ended("error: there is not enough memory for this; take shorter logs or fewer runs", 2)
        except KeyboardInterrupt:
            ended("stopped", _STOPPED)
        except click.exceptions.ClickException:
            raise
        except Exception as error:
            if isinstance(error, _bad_input()):
                ended(f"error: {error}", 2)
            if _followed_an_interrupt(error):
                ended("stopped", _STOPPED)
            if os.environ.get("PYIDENT_TRACEBACK"):
                raise
            ended(f"fault in pyident itself: {type(error).__name__}: {error} (the environment variable "
                  "PYIDENT_TRACEBACK=1 shows where); please report it", _OUR_FAULT)  # fmt: skip

    return run


def _bad_input() -> tuple[type[Exception], ...]:
    """Errors that a user mends; what they come from was loaded by the command that raised one of them."""
    from flexmodels.compiling.compiler import BuildError
    from flexmodels.effects.law_names import EffectError
    from flexmodels.inputs import SimulationError
    from flexmodels.robot import RobotError
    from pyident.cli.common.outputs import OutputError
    from pyident.logs.log import LogError
    from pyident.simulation.processes.dask_cluster import WorkersError
    from pyident.simulation.references import ExperimentError
    from pyident.sweep.store import StudyError
    from pyident.workbench.project import ProjectError

    of_robots = (BuildError, EffectError, RobotError, SimulationError, ExperimentError)
    return (*of_robots, LogError, OutputError, ProjectError, StudyError, WorkersError)


def _followed_an_interrupt(error: BaseException | None) -> bool:
    """Whether it was raised while something made way for a Ctrl-C."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


def ended(sentence: str, code: int) -> NoReturn:
    """Say one line on the error stream and leave."""
    click.echo(printable(sentence), err=True)
    sys.exit(code)


def reason(error: OSError) -> str:
    """What went wrong with which file, in words, whatever of it is known."""
    words = error.strerror or str(error) or type(error).__name__
    return f"{error.filename}: {words}" if error.filename else words


def printable(text: str) -> str:
    """The text with every character that a terminal would obey written as its code."""
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in text)


def show(sentence: str) -> None:
    """Say one line; who has closed the pipe, as `head` does, has heard enough."""
    try:
        click.echo(printable(sentence))
    except BrokenPipeError:
        with open(os.devnull, "wb") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())


def show_notes(notes: Iterable[str]) -> None:
    """Say what was done to the logs."""
    for note in notes:
        show(f"note: {note}")


@contextmanager
def progress_bar(text: str) -> Iterator[Callable[[float], None]]:
    """What to call with the share that is done: a bar in a terminal, else a line now and then."""
    terminal = Console(stderr=True)
    if not terminal.is_terminal:
        with repeated(lines(printable(text))) as progress:
            yield progress
        return
    with Progress(console=terminal, transient=True) as bar:
        task = bar.add_task(escape(printable(text)), total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)


def write_json(path: str | None, content: Any) -> None:
    """For `--json`; nothing where no path is given."""
    if path:
        with replacing(path) as file:
            file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def output_option(
    kind: Kind, required: bool = True, default: str | None = None
) -> Callable[[Command], Command]:
    """`-o FILE` of one kind; with a default it need not be given."""
    endings = ", ".join(kind.endings)
    # to click a default of None is one, and then nothing is required
    given: dict[str, Any] = {"required": required} if default is None else {"default": default}
    option = click.option(
        "-o",
        "--output",
        **given,
        show_default=default is not None,
        type=Output(kind),
        help=f"{kind.what[0].upper()}{kind.what[1:]} to write ({endings}).",
    )
    return lambda command: _with_overwrite(option(command))


def json_option(command: Command) -> Command:
    """`--json FILE`"""
    option = click.option(
        "--json", "json_file", type=Output(JSON), help="Write the result for machines (.json)."
    )
    return _with_overwrite(option(command))


def effects_option(command: Command) -> Command:
    """`--allow-effects`: without it a robot file is data."""
    return click.option(
        "--allow-effects",
        is_flag=True,
        expose_value=False,
        callback=_allow_effects,
        help="Run the Python files that the given files refer to.",
    )(command)


def _allow_effects(context: click.Context, _: click.Parameter, value: bool) -> None:
    if value:
        from flexmodels.effects.trust import code_allowed

        context.with_resource(code_allowed())


def scheduler_option(command: Command) -> Command:
    """`--scheduler ADDRESS`, wherever many simulations are made."""
    return click.option(
        "--scheduler",
        metavar="ADDRESS",
        expose_value=False,
        callback=_configure_scheduler,
        help="Address of a Dask cluster to simulate on, such as tcp://host:8786.",
    )(command)


def _configure_scheduler(context: click.Context, _: click.Parameter, address: str | None) -> None:
    if address is None:
        return
    from pyident.simulation.processes.dask_cluster import WorkersError, scheduler_configured

    try:
        context.with_resource(scheduler_configured(address))
    except WorkersError as error:
        raise click.UsageError(str(error)) from None


def force_option(command: Command) -> Command:
    """`--force`, wherever a log is believed."""
    return click.option(
        "--force", is_flag=True, help="Use logs even if the checks refuse them as grossly wrong."
    )(command)


def mapping_option(command: Command) -> Command:
    """`--mapping FILE`, wherever a log is read."""
    return click.option(
        "--mapping",
        metavar="FILE",
        help="Names, units and signs of the logs' columns: TOML, or a shipped name.",
    )(command)


def set_option(command: Command) -> Command:
    """`--set NAME=VALUE`, wherever something is simulated; a dictionary in `parameters`."""
    return assignments(
        "--set",
        "parameters",
        "joint1.coulomb=3.5",
        "Value of a parameter in SI units, instead of the model's",
    )(command)


def assignments(flag: str, name: str, example: str, text: str) -> Callable[[Command], Command]:
    """An option NAME=VALUE that is repeatable; a dictionary in `name`."""
    return click.option(
        flag,
        name,
        multiple=True,
        metavar="NAME=VALUE",
        callback=lambda context, option, given: dict(_assignment(one, example) for one in given),
        help=f"{text}; repeatable.",
    )


def assignments_in_logs(command: Command) -> Command:
    """`--set-in LOG NAME=VALUE`; (log, name, value) each in `in_logs`."""
    return click.option(
        "--set-in",
        "in_logs",
        nargs=2,
        multiple=True,
        metavar="LOG NAME=VALUE",
        callback=lambda context, option, given: [
            (log, *_assignment(one, "servo.kp=800")) for log, one in given
        ],
        help="The same of one LOG alone, such as another gain of its servos; repeatable.",
    )(command)


def _assignment(text: str, example: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not name.strip() or not math.isfinite(number):
        raise click.BadParameter(f"{text!r} is not NAME=VALUE with a finite number, such as {example}")
    return name.strip(), number


def _with_overwrite(command: Command) -> Command:
    """`--overwrite`, once."""
    if any(option.name == "overwrite" for option in getattr(command, "__click_params__", ())):
        return command
    return click.option(
        "--overwrite",
        is_flag=True,
        expose_value=False,
        is_eager=True,
        callback=lambda context, _, value: context.meta.update({OVERWRITE: value}),
        help="Also overwrite existing files of another kind.",
    )(command)
