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
    set_option,
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
@set_option
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
    parameters: dict[str, float],
    force: bool,
    json_file: str | None,
) -> None:
    """Identify the dynamic parameters of MODEL from LOGS.

    A MODEL with a [servo] table is fitted in closed loop to positions alone; --set gives what is known of
    its servos, such as servo.kp=400.

    Example: pyident identify four_link log.parquet -o identified.toml
    """
    if robust and refine:
        raise click.UsageError("--robust weighs the equations of the regression; --refine does without them")
    if pi.load_robot(model).servo is not None:
        with progress_bar("fitting in closed loop") as progress:
            of_servo = pi.identify_servo(
                model, logs, mapping=mapping, parameters=parameters, progress=progress
            )
        _report(of_servo, output, json_file)
        return
    if parameters:
        raise click.UsageError("--set is for robots with a [servo]: a regression finds every parameter")
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
    _report(found, output, json_file)


def _report(found: "pi.Fit | pi.ServoFit", output: str | None, json_file: str | None) -> None:
    show_notes(found.notes)
    show(found.summary())
    if output:
        found.save(output)
        show(f"wrote {output}")
    write_json(json_file, found.to_dict())
