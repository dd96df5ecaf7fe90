"""`pyident log` and `pyident data`: other people's recordings."""

import click

import pyident as pi
from pyident.cli.common.outputs import LOG
from pyident.cli.common.shared import (
    effects_option,
    json_option,
    output_option,
    reported,
    show,
    write_json,
)
from pyident.cli.inspect import inspect_command


@click.group()
def log() -> None:
    """Read recordings of other tools.

    Example: pyident log import raw.mat --mapping my_columns.toml -o log.parquet
    """


@log.command(name="import")
@click.argument("files", nargs=-1, required=True)
@click.option(
    "--mapping",
    metavar="FILE",
    help="Names, units and signs of the columns: TOML, or a shipped name. Default: what `log inspect` finds, "
    "where that leaves no question.",
)
@click.option("--robot", "model", metavar="MODEL", help="Refer motor-side columns to this robot's joints.")
@click.option("--skew", is_flag=True, help="Estimate and correct the delay of link encoders (needs --robot).")
@output_option(LOG)
@effects_option
@json_option
@reported
def import_command(
    files: tuple[str, ...],
    mapping: str | None,
    model: str | None,
    skew: bool,
    output: str,
    json_file: str | None,
) -> None:
    """Join FILES of one recording and write them as a log.

    Example: pyident log import positions.csv torques.csv --mapping tx40 --robot tx40 -o log.parquet
    """
    if skew and model is None:
        raise click.UsageError("--skew needs --robot")
    from pyident.inspection.inspect_log import certain_mapping
    from pyident.logs.foreign import import_log
    from pyident.logs.mapping import read_mapping

    robot = pi.load_robot(model) if model else None
    read = import_log(files, read_mapping(mapping) if mapping else certain_mapping(files, robot), robot)
    notes = [] if mapping else ["columns are taken for what `pyident log inspect` says they are"]
    notes += read.notes
    if skew and robot is not None:
        from pyident.checks.encoder_delay import encoder_skews, without_skew

        read, sentences = without_skew(read, encoder_skews(robot, read))
        notes += sentences
    pi.write_log(read, output)
    for note in notes:
        show(f"note: {note}")
    show(f"wrote {output}: {len(read)} samples at {1 / read.period:g} Hz")
    write_json(json_file, {"log": output, "samples": len(read), "notes": notes})


log.add_command(inspect_command)


@click.group()
def data() -> None:
    """Public measurements of real robots.

    Example: pyident data list
    """


@data.command(name="list")
@json_option
@reported
def list_command(json_file: str | None) -> None:
    """List the data sets. Example: pyident data list"""
    from pyident.logs.datasets import DATA_SETS
    from pyident.verbs.terminal.table import table

    rows = [(name, found.title, found.licence) for name, found in DATA_SETS.items()]
    show(table(("data set", "what", "licence"), rows))
    write_json(json_file, {name: found.title for name, found in DATA_SETS.items()})


@data.command(name="fetch")
@click.argument("name")
@json_option
@reported
def fetch_command(name: str, json_file: str | None) -> None:
    """Fetch a data set, or find it in the folder PYIDENT_DATA. Example: pyident data fetch tx40"""
    from pyident.logs.datasets import fetch

    files = fetch(name)
    for file in files:
        show(str(file))
    write_json(json_file, [str(file) for file in files])
