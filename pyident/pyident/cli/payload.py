"""`pyident payload`: what a robot carries."""

import click

import pyident as pi
from pyident.cli.common.outputs import ROBOT
from pyident.cli.common.shared import (
    effects_option,
    force_option,
    json_option,
    mapping_option,
    output_option,
    progress_bar,
    reported,
    show,
    show_notes,
    write_json,
)


@click.command(name="payload")
@click.argument("model")
@click.argument("empty")
@click.argument("loaded")
@output_option(ROBOT, required=False)
@effects_option
@mapping_option
@force_option
@json_option
@reported
def payload_command(
    model: str,
    empty: str,
    loaded: str,
    output: str | None,
    mapping: str | None,
    force: bool,
    json_file: str | None,
) -> None:
    """Find the ten inertial parameters of what MODEL carries in the log LOADED and not in EMPTY.

    Example: pyident payload four_link empty.parquet loaded.parquet -o loaded.toml
    """
    with progress_bar("identifying without and with it") as progress:
        load = pi.payload(model, empty, loaded, mapping=mapping, force=force, progress=progress)
    show_notes(load.notes)
    show(load.summary())
    if output:
        load.save(output)
        show(f"wrote {output}")
        show_notes([load.not_identified])
    write_json(json_file, load.to_dict())
