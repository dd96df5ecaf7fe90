"""Commands that are loaded when they are called, so that help and completion need nothing."""

import signal
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any, NamedTuple

import click


class Entry(NamedTuple):
    """Where a command is, and the first sentence of its help."""

    module: str
    attribute: str
    help: str


class LazyGroup(click.Group):
    """A group that knows the names of its commands and what they are for before it loads any."""

    entries: Mapping[str, Entry] = {}

    def make_context(self, *args: Any, **kwargs: Any) -> click.Context:
        with _stopped_in_one_line():
            return super().make_context(*args, **kwargs)

    def invoke(self, ctx: click.Context) -> Any:
        with _stopped_in_one_line():
            return super().invoke(ctx)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return sorted({*self.commands, *self.entries})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in self.entries:
            return super().get_command(ctx, cmd_name)
        entry = self.entries[cmd_name]
        return getattr(import_module(entry.module), entry.attribute)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, self._help(ctx, name)) for name in self.list_commands(ctx)])

    def _help(self, context: click.Context, name: str) -> str:
        """The first sentence of a command's help."""
        if name in self.entries:
            return self.entries[name].help
        command = self.get_command(context, name)
        return command.get_short_help_str() if command else ""


@contextmanager
def _stopped_in_one_line() -> Iterator[None]:
    """Ctrl-C while a command is read or loaded; click itself would call it aborted, with exit code 1."""
    try:
        yield
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        click.echo("stopped", err=True)
        raise SystemExit(128 + signal.SIGINT) from None


def lazy_group(entries: Mapping[str, Entry]) -> type[LazyGroup]:
    """The class of a group with these commands."""
    return type("Commands", (LazyGroup,), {"entries": entries})
