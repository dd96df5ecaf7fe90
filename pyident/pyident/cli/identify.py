"""`pyident identify`: logs -> parameters."""

import click

import pyident as pi
from pyident.cli.outputs import ROBOT
from pyident.cli.shared import (
    effects_option,
    json_option,
    mapping_option,
    output_option,
    progress_bar,
    reported,
    show,
    show_notes,
    write_json,
)


@click.command(name="identify")
@click.argument("model")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@output_option(ROBOT, required=False)
@effects_option
@click.option("--robust", is_flag=True, help="Give single equations that stick out less weight (Huber).")
@click.option(
    "--refine", is_flag=True, help="Go on until the simulated FMU follows the logs (a minute or so)."
)
@mapping_option
@json_option
@reported
def identify_command(
    model: str,
    logs: tuple[str, ...],
    output: str | None,
    robust: bool,
    refine: bool,
    mapping: str | None,
    json_file: str | None,
) -> None:
    """Identify the dynamic parameters of MODEL from LOGS.

    Example: pyident identify four_link log.parquet -o identified.toml
    """
    if robust and refine:
        raise click.UsageError("--robust weighs the equations of the regression; --refine does without them")
    with progress_bar("refining" if refine else "identifying") as progress:
        if refine:
            found = pi.refine(model, logs, mapping=mapping, progress=progress)
        else:
            found = pi.identify(model, logs, mapping=mapping, robust=robust, progress=progress)
    show_notes(found.notes)
    show(found.summary())
    if output:
        found.save(output)
        show(f"wrote {output}")
    write_json(json_file, found.to_dict())
