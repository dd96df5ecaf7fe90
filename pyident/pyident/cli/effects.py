"""`pyident effects`: the laws that a robot file may name."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

import pyident as pi
from pyident.cli.common.shared import json_option, reported, show, write_json

if TYPE_CHECKING:
    from flexmodels.effects.effect import Effect


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
    from flexmodels.effects import CATALOGUE
    from flexmodels.effects.effect import sheet

    laws = CATALOGUE if file is None else _own(file)
    if name is not None and name not in laws:
        raise pi.RobotError(f"unknown effect {name!r}; known are {', '.join(sorted(laws))}")
    chosen = {name: laws[name]} if name else laws
    if name is None and file is None:
        show(_listed(chosen))
    for effect in chosen.values() if name or file else ():
        show(_sheet(effect))
    if file is not None:
        show(f"{file}: {', '.join(laws)} may be named by a robot file that stands beside it")
    write_json(json_file, {n: {"title": e.title} | sheet(e) for n, e in chosen.items()})


def _own(file: str) -> "Mapping[str, Effect]":
    """The laws of a user's file. Raises EffectError."""
    from flexmodels.effects import effects_of
    from flexmodels.effects.law_names import EffectError

    if not Path(file).is_file():
        raise EffectError(f"there is no file {file}; check the path")
    return effects_of([str(Path(file).resolve())])


def _listed(laws: "Mapping[str, Effect]") -> str:
    from pyident.verbs.terminal.table import table

    rows = [(e.name, e.title, ", ".join(p.name for p in e.parameters), e.citation) for e in laws.values()]
    return table(("effect", "law", "parameters", "source"), rows)


def _sheet(effect: "Effect") -> str:
    from flexmodels.effects.effect import sheet
    from pyident.verbs.terminal.table import table

    return table((effect.name, effect.title), list(sheet(effect).items()))
