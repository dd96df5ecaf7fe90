"""`pyident identify`: logs -> parameters."""

import click

import pyident as pi
from pyident.cli.common.any_model import (
    SeveralNames,
    interface_option,
    parameters_option,
    refuse_robot_options,
)
from pyident.cli.common.outputs import PAGE, ROBOT, Output
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
from pyident.verbs.fmu.arguments import Interface, Parameters, is_fmu


@click.command(name="identify", cls=SeveralNames)
@click.argument("model")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@output_option(ROBOT, required=False)
@effects_option
@click.option("--robust", is_flag=True, help="Give outlying equations less weight (Huber): irls.")
@click.option(
    "--estimator",
    type=click.Choice(["iv", "oe", "wls", "irls", "ols", "pe", "tls"]),
    default="iv",
    show_default=True,
    help="Instrumental variables from a simulated model, output error, or regressions, which give no "
    "intervals, for comparison.",
)
@click.option(
    "--prior", metavar="MODEL", help="Robot from CAD or URDF: what the data leave open stays near its bodies."
)
@click.option(
    "--holdout", multiple=True, metavar="LOG", help="Log whose torque the model is judged on; repeatable."
)
@click.option("--page", type=Output(PAGE), help="Page (.html) of what was found, and of what is left.")
@click.option(
    "--refine", is_flag=True, help="Continue until the simulated FMU follows the logs (about a minute)."
)
@parameters_option
@interface_option
@set_option
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
    prior: str | None,
    holdout: tuple[str, ...],
    page: str | None,
    refine: bool,
    names: Parameters,
    interface: Interface | None,
    parameters: dict[str, float],
    mapping: str | None,
    force: bool,
    json_file: str | None,
) -> None:
    """Identify the dynamic parameters of MODEL from logs.

    MODEL may also be an FMU of any tool: --parameters then names what to find, and the logs' columns have
    the names of its inputs and outputs.

    A MODEL with a [servo] table is fitted in closed loop to positions alone; --set gives what is known of
    its servos, such as servo.kp=400.

    \b
    Example: pyident identify four_link log.parquet -o identified.toml
             pyident identify other.fmu log.csv --parameters k d=0:5
    """
    if is_fmu(model):
        refuse_robot_options(
            output=output,
            mapping=mapping,
            robust=robust,
            refine=refine,
            estimator=estimator != "iv",
            prior=prior,
            holdout=holdout,
            page=page,
        )
        if not names:
            raise click.UsageError(f"name the parameters of {model} to identify, such as --parameters k")
        with progress_bar("identifying") as progress:
            fit = pi.identify_fmu(
                model, logs, names, values=parameters, interface=interface, progress=progress
            )
        show_notes(fit.notes)
        show(fit.summary())
        write_json(json_file, fit.to_dict())
        return
    if names or interface:
        raise click.UsageError("--parameters and --interface belong to an FMU as the model")
    if pi.load_robot(model).servo is not None:
        if page or holdout:
            raise click.UsageError(
                "--page and --holdout judge torques, and a robot with a [servo] is fitted to positions"
            )
        with progress_bar("fitting in closed loop") as progress:
            servo = pi.identify_servo(model, logs, mapping=mapping, parameters=parameters, progress=progress)
        show_notes(servo.notes)
        show(servo.summary())
        if output:
            servo.save(output)
            show(f"wrote {output}")
        write_json(json_file, servo.to_dict())
        return
    if parameters:
        raise click.UsageError("--set belongs to an FMU as the model, or to a robot with a [servo]")
    if estimator != "iv" and (robust or refine):
        option = "--robust is the estimator irls" if robust else "--refine is the estimator oe"
        raise click.UsageError(f"{option}; leave --estimator out, or give it alone")
    if robust and refine:
        raise click.UsageError("--robust weighs the equations of the regression; --refine does without them")
    if holdout and refine:
        raise click.UsageError(
            "--holdout judges the regression's torques; compare what --refine writes instead"
        )
    if prior and refine:
        raise click.UsageError("--prior settles what a regression leaves open; --refine does not use it")
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
                prior=prior,
                heldout=holdout,
                progress=progress,
            )
    show_notes(found.notes)
    show(found.summary())
    if output:
        found.save(output)
        show(f"wrote {output}")
    if page:
        found.save_page(page)
        show(f"wrote {page}")
    write_json(json_file, found.to_dict())
