"""Options of the commands that take an FMU of any tool as their model."""

from collections.abc import Callable
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])
_PARAMETERS = "--parameters"


class SeveralNames(click.Command):
    """`--parameters a b c` is `--parameters a --parameters b --parameters c`."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        out, listing = [], False
        for word in args:
            if word.startswith("-"):
                listing = word == _PARAMETERS
                out += [] if listing else [word]
            else:
                out += [_PARAMETERS, word] if listing else [word]
        return super().parse_args(ctx, out)


def parameters_option(command: Command) -> Command:
    """`--parameters NAME[=LOW:HIGH]...`; a dictionary with bounds, or a tuple of names, in `names`."""
    return click.option(
        _PARAMETERS,
        "names",
        multiple=True,
        metavar="NAME[=LOW:HIGH]...",
        callback=lambda context, option, given: _bounded(given),
        help="Parameters of an FMU to identify, with bounds if you like; give them after the logs.",
    )(command)


def interface_option(command: Command) -> Command:
    """`--interface`, of an FMU that has both."""
    return click.option(
        "--interface",
        type=click.Choice(["CoSimulation", "ModelExchange"]),
        help="How an FMU is run.  [default: CoSimulation if the FMU has it]",
    )(command)


def refuse_robot_options(**given: object) -> None:
    """Raises UsageError for options that an FMU as the model does not take."""
    refuse_options("a robot file as the model, not to an FMU", **given)


def refuse_options(belong_to: str, **given: object) -> None:
    """Raises UsageError for the first of some options that is given, with what it belongs to."""
    for name, value in given.items():
        if value:
            raise click.UsageError(f"--{name} belongs to {belong_to}")


def _bounded(given: tuple[str, ...]) -> "dict[str, tuple[float, float] | None]":
    out = {}
    for word in given:
        name, equals, span = word.partition("=")
        if name in out:
            raise click.BadParameter(f"{name} is named twice")
        low, _, high = span.partition(":")
        try:
            out[name] = (float(low), float(high)) if equals else None
        except ValueError:
            raise click.BadParameter(f"{word!r} is not NAME or NAME=LOW:HIGH, such as k=0.5:2") from None
    return out
