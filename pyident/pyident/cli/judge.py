"""Commands that judge a model: compare, diagnose, add."""

import sys
from pathlib import Path

import click

import pyident as pi
from flexmodels.atomic import replacing
from pyident.cli.common.any_model import (
    SeveralNames,
    interface_option,
    parameters_option,
    refuse_robot_options,
)
from pyident.cli.common.outputs import DRAFT, PAGE, ROBOT, Output
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

_holdout = click.option(
    "--holdout",
    multiple=True,
    metavar="LOG",
    help="Log to judge on; repeatable.  [default: the last, or its last third]",
)


@click.command(name="compare")
@click.argument("models_and_logs", nargs=-1, required=True, metavar="MODEL [MODEL] LOG...")
@output_option(PAGE, required=False)
@effects_option
@mapping_option
@scheduler_option
@force_option
@interface_option
@set_option
@json_option
@reported
def compare_command(
    models_and_logs: tuple[str, ...],
    output: str | None,
    mapping: str | None,
    force: bool,
    interface: Interface | None,
    parameters: dict[str, float],
    json_file: str | None,
) -> None:
    """Show where an identified MODEL fails on logs, and by how much compared with the method's own floor.

    The floor is what fit and simulation leave on replicas: logs that the model itself made over the same
    motion with the same sensor noise. With two models, OLD and NEW, both are shown side by side.

    \b
    Example: pyident compare identified.toml log.parquet -o where.html
             pyident compare identified.toml extended.toml validation.parquet
             pyident compare other.fmu log.csv --set k=1.7
    """
    if is_fmu(models_and_logs[0]):
        refuse_robot_options(output=output, mapping=mapping)
        fmu = pi.compare_fmu(models_and_logs[0], models_and_logs[1:], values=parameters, interface=interface)
        show_notes(fmu.notes)
        show(fmu.summary())
        write_json(json_file, fmu.to_dict())
        return
    models, paths = _models_and_logs(models_and_logs)
    found = []
    for model in models:
        with progress_bar(f"{model} and its replicas") as progress:
            found.append(
                pi.compare(
                    model, paths, mapping=mapping, force=force, parameters=parameters, progress=progress
                )
            )
    show_notes(found[-1].notes)
    from pyident.verbs.judged import side_by_side

    show(side_by_side(models, found))
    if output:
        from pyident.report.comparison import write_comparison

        write_comparison(Path(output), models, [c.comparison for c in found], found[-1].notes, found[-1].arms)
        show(f"wrote {output}")
    contents = [c.to_dict() for c in found]
    write_json(json_file, contents[0] if len(found) == 1 else contents[1] | {"old": contents[0]})


@click.command(name="diagnose", cls=SeveralNames)
@click.argument("model")
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@_holdout
@click.option(
    "--draft",
    type=Output(DRAFT),
    metavar="FILE.py",
    help="Effect file to propose where no law explains the residual.  [needs: flexident[symbolic]]",
)
@output_option(PAGE, required=False)
@effects_option
@parameters_option
@interface_option
@set_option
@mapping_option
@scheduler_option
@force_option
@json_option
@reported
def diagnose_command(
    model: str,
    logs: tuple[str, ...],
    holdout: tuple[str, ...],
    draft: str | None,
    output: str | None,
    names: Parameters,
    interface: Interface | None,
    parameters: dict[str, float],
    mapping: str | None,
    force: bool,
    json_file: str | None,
) -> None:
    """Say which physical effect MODEL lacks: one, several that cannot be told apart, none in the catalogue,
    or nothing.

    The model is fitted to the logs; its own masses, frictions and stiffnesses are not used. The exit code is
    1 when something is missing.

    Of an FMU of any tool it says what its output residuals show, after a fit of --parameters: a delay, the
    signals on which they depend, periodic orders, or noise.

    \b
    Example: pyident diagnose my_arm.toml a.csv b.csv c.csv -o diagnosis.html
             pyident diagnose other.fmu log.csv --parameters k d
    """
    if is_fmu(model):
        refuse_robot_options(output=output, mapping=mapping, draft=draft, holdout=holdout)
        with progress_bar("fitting, search") as progress:
            fmu = pi.diagnose_fmu(
                model, logs, names, values=parameters, interface=interface, progress=progress
            )
        show_notes(fmu.notes)
        show(fmu.summary())
        write_json(json_file, fmu.to_dict())
        sys.exit(fmu.verdict != "nothing_detectable")
    if names or interface:
        raise click.UsageError("--parameters and --interface belong to an FMU as the model")
    with progress_bar("fitting, replicas, search") as progress:
        found = pi.diagnose(
            model,
            logs,
            heldout=holdout,
            mapping=mapping,
            parameters=parameters,
            force=force,
            draft=draft is not None,
            progress=progress,
        )
    show_notes(found.notes)
    show(found.summary())
    if output:
        found.save(output, model)
        show(f"wrote {output}")
    if draft and found.diagnosis.draft:
        with replacing(draft) as file:
            file.write_text(found.diagnosis.draft, encoding="utf-8")
        show(f"wrote {draft}")
    write_json(json_file, found.to_dict())
    if found.verdict != "nothing_detectable":
        sys.exit(1)


@click.command(name="add")
@click.argument("model")
@click.argument("effect")
@click.option("--joint", metavar="K", help="Where the effect acts: from 1, or the joint's name.")
@click.argument("logs", nargs=-1, required=True, metavar="[PLACE] LOG...")
@_holdout
@output_option(ROBOT)
@effects_option
@set_option
@mapping_option
@scheduler_option
@force_option
@json_option
@reported
def add_command(
    model: str,
    effect: str,
    joint: str | None,
    logs: tuple[str, ...],
    holdout: tuple[str, ...],
    output: str,
    parameters: dict[str, float],
    mapping: str | None,
    force: bool,
    json_file: str | None,
) -> None:
    """Add EFFECT to MODEL and judge it on held-out data; it is written if these are followed better.

    The effect must pass the same gate as in `diagnose`, and the simulation error must fall on data that were
    not fitted; otherwise nothing is written and the exit code is 1. EFFECT `geometry` corrects the
    description at PLACE: joint3.origin[z] (m), joint2.axis[y], joint2.encoder_zero, base_tilt[x] (rad).

    \b
    Example: pyident add arm.toml stribeck --joint 2 a.csv b.csv -o better.toml
             pyident add arm.toml geometry 'joint3.origin[z]' a.csv -o better.toml
    """
    effect, number, logs = _what(model, effect, joint, logs)
    with progress_bar(f"{effect} at joint {number}") as progress:
        found = pi.add_effect(
            model,
            effect,
            number,
            logs,
            heldout=holdout,
            mapping=mapping,
            parameters=parameters,
            force=force,
            progress=progress,
        )
    show_notes(found.notes)
    show(found.summary())
    write_json(json_file, found.to_dict())
    if not found.accepted:
        sys.exit(1)
    found.save(output)
    show(f"wrote {output}")


def _what(
    model: str, effect: str, joint: str | None, words: tuple[str, ...]
) -> tuple[str, int, tuple[str, ...]]:
    """Effect, joint and logs. Raises RobotError."""
    if effect != "geometry":
        if joint is None:
            raise pi.RobotError(f"where does {effect} act? Give --joint K, from 1")
        return effect, int(joint) if joint.isdecimal() else _number(model, joint), words
    from flexmodels.files.robot_file import load_robot
    from pyident.regression.descriptions import parsed

    place, *logs = words or ("",)
    number, name = parsed(load_robot(model), place)
    if not logs:
        raise pi.RobotError(f"there is no log; give one or more behind {place}")
    return name, number, tuple(logs)


def _number(model: str, joint: str) -> int:
    """Of a joint by its name. Raises RobotError."""
    from flexmodels.files.robot_file import load_robot

    robot = load_robot(model)
    if joint not in robot.joint_numbers:
        names = ", ".join(robot.joint_numbers)
        raise pi.RobotError(f"robot {robot.name} has no joint {joint}; its joints are {names}")
    return robot.joint_numbers[joint]


def _models_and_logs(given: tuple[str, ...]) -> tuple[list[str], list[str]]:
    from flexmodels.files.robot_file import shipped

    models = [word for word in given[:2] if word.endswith(".toml") or word in shipped()]
    logs = [word for word in given if word not in models]
    if not models or given[: len(models)] != tuple(models):
        raise pi.RobotError(f"{given[0]} is neither a shipped robot nor a .toml file; give the model first")
    if not logs:
        raise pi.RobotError("there is no log to compare with; give one or more behind the model")
    return models, logs
