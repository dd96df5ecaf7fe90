"""`pyident effects`: the laws that a robot file may name."""

from collections.abc import Mapping
from pathlib import Path

import click

from flexmodels.effects import CATALOGUE, effects_of
from flexmodels.effects.effect import Effect, sheet
from flexmodels.effects.law_names import EffectError
from flexmodels.robot import RobotError
from pyident.cli.common.shared import json_option, reported, show, write_json
from pyident.verbs.terminal.table import table


@click.command()
@click.argument("name", required=False)
@click.option("--file", "file", metavar="FILE.py", help="Run this file, check its laws and show them.")
@json_option
@reported
def effects(name: str | None, file: str | None, json_file: str | None) -> None:
    """List the laws that a robot file may name, or show one.

    With --file, laws of your own are checked before a robot uses them.

    \b
    Example: pyident effects stribeck
             pyident effects --file my_friction.py
    """
    laws = CATALOGUE if file is None else _own(file)
    if name is not None and name not in laws:
        raise RobotError(f"unknown effect {name!r}; known are {', '.join(sorted(laws))}")
    chosen = {name: laws[name]} if name else laws
    if name is None and file is None:
        show(_listed(chosen))
    for effect in chosen.values() if name or file else ():
        show(_sheet(effect))
    if file is not None:
        show(f"{file}: {', '.join(laws)} may be named by a robot file that stands beside it")
    write_json(json_file, {n: {"title": e.title} | sheet(e) for n, e in chosen.items()})


def _own(file: str) -> Mapping[str, Effect]:
    """The laws of a user's file. Raises EffectError."""
    if not Path(file).is_file():
        raise EffectError(f"there is no file {file}; check the path")
    return effects_of([str(Path(file).resolve())])


def _listed(laws: Mapping[str, Effect]) -> str:
    rows = [(e.name, e.title, ", ".join(p.name for p in e.parameters), e.citation) for e in laws.values()]
    return table(("effect", "law", "parameters", "source"), rows)


def _sheet(effect: Effect) -> str:
    return table((effect.name, effect.title), list(sheet(effect).items()))
