"""`pyident identify`: logs -> parameters."""

from collections.abc import Mapping
from typing import Any

import click

import pyident as pi
from pyident.cli.common.any_model import (
    SeveralNames,
    interface_option,
    parameters_option,
    refuse_options,
    refuse_robot_options,
)
from pyident.cli.common.outputs import PAGE, ROBOT, Output
from pyident.cli.common.shared import (
    assignments_in_logs,
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

_DEFAULT = "iv"  # as of `pi.identify`
_TORQUES = "a fit to torques, and a robot with a [servo] is fitted to positions"


@click.command(name="identify", cls=SeveralNames)
@click.argument("model")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@output_option(ROBOT, required=False)
@effects_option
@click.option("--robust", is_flag=True, help="Give outlying equations less weight (Huber): irls.")
@click.option(
    "--estimator",
    type=click.Choice(["iv", "oe", "wls", "irls", "ols", "pe", "tls"]),
    show_default=_DEFAULT,
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
    "--refine", is_flag=True, help="Continue until the simulated FMU follows the logs (about a minute): oe."
)
@parameters_option
@interface_option
@set_option
@assignments_in_logs
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
    estimator: str | None,
    prior: str | None,
    holdout: tuple[str, ...],
    page: str | None,
    refine: bool,
    names: Parameters,
    interface: Interface | None,
    parameters: dict[str, float],
    in_logs: list[tuple[str, str, float]],
    mapping: str | None,
    force: bool,
    json_file: str | None,
) -> None:
    """Identify the dynamic parameters of MODEL from logs.

    MODEL may also be an FMU of any tool: --parameters then names what to find, and the logs' columns have
    the names of its inputs and outputs.

    A MODEL with a [servo] table is fitted in closed loop to positions alone; --set gives what is known of
    its servos, such as servo.kp=400, and --set-in what differs from log to log.

    \b
    Example: pyident identify four_link log.parquet -o identified.toml
             pyident identify other.fmu log.csv --parameters k d=0:5
    """
    options = {"robust": robust, "refine": refine, "estimator": estimator is not None, "prior": prior}
    options |= {"holdout": holdout, "page": page}
    if in_logs and (is_fmu(model) or pi.load_robot(model).servo is None):
        raise click.UsageError("--set-in belongs to a robot with a [servo]")
    if is_fmu(model):
        refuse_robot_options(**options, output=output, mapping=mapping, force=force)
        fit = _fmu(model, logs, names, parameters, interface)
    elif names or interface:
        raise click.UsageError("--parameters and --interface belong to an FMU as the model")
    elif pi.load_robot(model).servo is not None:
        refuse_options(_TORQUES, **options)
        with progress_bar("fitting in closed loop") as progress:
            fit = pi.identify_servo(
                model, logs, mapping=mapping, parameters=parameters, settings=_settings(logs, in_logs),
                force=force, progress=progress,
            )  # fmt: skip
    elif parameters:
        raise click.UsageError("--set belongs to an FMU as the model, or to a robot with a [servo]")
    else:
        given = {"mapping": mapping, "force": force, "prior": prior, "heldout": holdout}
        fit = _robot(model, logs, _estimator(estimator, robust, refine), given)
    show_notes(fit.notes)
    show(fit.summary())
    if output and not isinstance(fit, pi.FmuFit):
        fit.save(output)
        show(f"wrote {output}")
    if page and isinstance(fit, pi.Fit):
        fit.save_page(page)
        show(f"wrote {page}")
    write_json(json_file, fit.to_dict())


def _settings(
    logs: tuple[str, ...], in_logs: list[tuple[str, str, float]]
) -> tuple[Mapping[str, float], ...]:
    """What is known of each log alone; none where nothing is. Raises UsageError."""
    for log, name, _ in in_logs:
        if log not in logs:
            raise click.UsageError(
                f"--set-in {log} {name}: it is none of the logs; write it as it stands there"
            )
    each = ({name: value for log, name, value in in_logs if log == one} for one in logs)
    return tuple(each) if in_logs else ()


def _fmu(
    model: str,
    logs: tuple[str, ...],
    names: Parameters,
    values: dict[str, float],
    interface: Interface | None,
) -> "pi.FmuFit":
    if not names:
        raise click.UsageError(f"name the parameters of {model} to identify, such as --parameters k")
    with progress_bar("identifying") as progress:
        return pi.identify_fmu(model, logs, names, values=values, interface=interface, progress=progress)


def _estimator(name: str | None, robust: bool, refine: bool) -> str:
    """Raises UsageError where two are asked for."""
    short = {"--robust": "irls"} if robust else {}
    short |= {"--refine": "oe"} if refine else {}
    if len(short) > 1:
        raise click.UsageError(
            "--robust is the estimator irls and --refine the estimator oe; give one of them"
        )
    for option, own in short.items():
        if name not in (None, own):
            raise click.UsageError(
                f"{option} is the estimator {own}; leave --estimator out, or give it alone"
            )
        return own
    return name or _DEFAULT


def _robot(model: str, logs: tuple[str, ...], estimator: str, given: Mapping[str, Any]) -> "pi.Fit":
    if estimator == "oe":
        with progress_bar("refining") as progress:
            return pi.refine(model, logs, **given, progress=progress)
    with progress_bar("identifying") as progress:
        return pi.identify(model, logs, **given, estimator=estimator, progress=progress)
