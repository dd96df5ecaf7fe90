"""`pyident identify`: logs -> parameters."""

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
    scheduler_option,
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
    "--estimator",
    type=click.Choice(["iv", "oe", "wls", "irls", "ols", "tls"]),
    default="iv",
    show_default=True,
    help="Instruments from the simulated model, output error, or a least squares for comparison.",
)
@click.option(
    "--refine", is_flag=True, help="Go on until the simulated FMU follows the logs (a minute or so)."
)
@mapping_option
@scheduler_option
@force_option
@json_option
@reported
def identify_command(
    model: str,
    logs: tuple[str, ...],
    output: str | None,
    robust: bool,
    estimator: str,
    refine: bool,
    mapping: str | None,
    force: bool,
    json_file: str | None,
) -> None:
    """Identify the dynamic parameters of MODEL from LOGS.

    Example: pyident identify four_link log.parquet -o identified.toml
    """
    if robust and refine:
        raise click.UsageError("--robust weighs the equations of the regression; --refine does without them")
    with progress_bar("refining" if refine else "identifying") as progress:
        if refine:
            found = pi.refine(model, logs, mapping=mapping, force=force, progress=progress)
        else:
            found = pi.identify(
                model,
                logs,
                mapping=mapping,
                force=force,
                robust=robust,
                estimator=estimator,
                progress=progress,
            )
    show_notes(found.notes)
    show(found.summary())
    if output:
        found.save(output)
        show(f"wrote {output}")
    write_json(json_file, found.to_dict())
