"""`pyident effects`: the laws that a robot file may name."""

import click
from rich.table import Table

from flexmodels.effects import CATALOGUE
from flexmodels.effects.effect import sheet
from flexmodels.robot import RobotError
from pyident.cli.shared import console, json_option, reported, write_json


@click.command()
@click.argument("name", required=False)
@json_option
@reported
def effects(name: str | None, json_file: str | None) -> None:
    """List the laws that a robot file may name, or show what is known of one.

    Example: pyident effects stribeck
    """
    if name is not None and name not in CATALOGUE:
        raise RobotError(f"unknown effect {name!r}; known are {', '.join(sorted(CATALOGUE))}")
    chosen = CATALOGUE if name is None else {name: CATALOGUE[name]}
    if name is None:
        table = Table("effect", "law", "parameters", "source")
        for effect in CATALOGUE.values():
            parameters = ", ".join(p.name for p in effect.parameters)
            table.add_row(effect.name, effect.title, parameters, effect.citation)
    else:
        table = Table(name, show_lines=True)
        table.add_column(CATALOGUE[name].title)
        for key, text in sheet(CATALOGUE[name]).items():
            table.add_row(key, text)
    console.print(table)
    write_json(json_file, {n: {"title": e.title} | sheet(e) for n, e in chosen.items()})
