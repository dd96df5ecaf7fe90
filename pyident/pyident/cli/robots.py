"""`pyident robots`: what ships, and robots from and to other people's files."""

import click

import pyident as pi
from pyident.cli.common.outputs import JSON, MODEL, ROBOT
from pyident.cli.common.shared import (
    effects_option,
    json_option,
    mapping_option,
    output_option,
    reported,
    show,
    write_json,
)


@click.group(invoke_without_command=True)
@click.pass_context
@json_option
@reported
def robots(context: click.Context, json_file: str | None) -> None:
    """List the robots that ship, or copy one; import and export others.

    Example: pyident robots
    """
    if context.invoked_subcommand is None:
        _list(json_file)


def _list(json_file: str | None) -> None:
    from flexmodels.files.robot_file import shipped
    from pyident.verbs.terminal.table import table

    listed = {name: pi.load_robot(file) for name, file in shipped().items()}
    rows = [(n, str(len(r.joints)), str(len(r.parameters)), r.description) for n, r in listed.items()]
    show(table(("robot", "joints", "parameters", "description"), rows, numbers=(1, 2)))
    write_json(json_file, {name: robot.description for name, robot in listed.items()})


@robots.command(name="import")
@click.argument("file")
@output_option(ROBOT)
@click.option("--flexible", default="", metavar="K,...", help="Joints that twist and bend.")
@click.option("--twist", default="", metavar="K,...", help="Joints that only twist.")
@click.option(
    "--fixed",
    multiple=True,
    metavar="NAME,...",
    help="Joints of a URDF that stand still at zero, such as a gripper's fingers; may be repeated.",
)
@json_option
@reported
def import_command(
    file: str, output: str, flexible: str, twist: str, fixed: tuple[str, ...], json_file: str | None
) -> None:
    """Write the robot of a URDF or of an MJCF (.xml) as a robot file.

    Example: pyident robots import arm.xml -o arm.toml --flexible 1,2 --twist 3
    """
    from flexmodels.files.formats import imported
    from flexmodels.files.robot_file import check_readable

    bent, twisted = _numbers(flexible, "--flexible"), _numbers(twist, "--twist")
    robot, notes = imported(file, bent, twisted, _words(",".join(fixed)))
    check_readable(robot)
    pi.save_robot(robot, output)
    names = ", ".join(f"{k} {joint.name}" for k, joint in robot.numbered)
    show(f"wrote {output}: joints {names}")
    for note in notes:
        show(f"note: {note}")
    content = {"robot": output, "joints": [joint.name for joint in robot.joints], "notes": list(notes)}
    write_json(json_file, content)


@robots.command(name="copy")
@click.argument("name")
@output_option(ROBOT)
@reported
def copy_command(name: str, output: str) -> None:
    """Write the file of the robot NAME that ships, to start from.

    Example: pyident robots copy four_link -o my_arm.toml
    """
    from flexmodels.atomic import replacing
    from flexmodels.files.robot_file import shipped

    files = shipped()
    if name not in files:
        raise pi.RobotError(f"no robot {name} ships; there are {', '.join(files)}")
    with replacing(output) as file:
        file.write_bytes(files[name].read_bytes())
    show(f"wrote {output}")


@robots.command(name="schema")
@output_option(JSON)
@reported
def schema_command(output: str) -> None:
    """Write the JSON Schema of robot files, by which editors complete and explain the keys.

    A robot file names it in its first line: `#:schema robot.schema.json`.

    Example: pyident robots schema -o robot.schema.json
    """
    from flexmodels.files.schema import schema

    write_json(output, schema())
    show(f"wrote {output}")


@robots.command(name="export")
@click.argument("model")
@output_option(MODEL)
@click.option(
    "--log",
    "logs",
    multiple=True,
    metavar="LOG",
    help="Report what the export loses on this log; repeatable.",
)
@mapping_option
@effects_option
@json_option
@reported
def export_command(
    model: str, output: str, logs: tuple[str, ...], mapping: str | None, json_file: str | None
) -> None:
    """Write MODEL for other simulators: a URDF, an MJCF (.xml), or five numbers per joint (.json).

    The five numbers are armature, damping, friction, bias and delay, as simulators for learning take them.
    What is lost on a log without torques is told by its positions, simulated in closed loop.

    Example: pyident robots export identified.toml -o identified.xml --log log.parquet
    """
    from flexmodels.files.formats import exported
    from pyident.comparison.export_cost import cost_of_export
    from pyident.logs.foreign import robot_log
    from pyident.logs.mapping import read_mapping
    from pyident.simulation.fmu_runs import FmuRuns

    robot = pi.load_robot(model)
    notes, kept = exported(robot, output)
    show(f"wrote {output}")
    columns = read_mapping(mapping) if mapping else None
    costs = {log: cost_of_export(robot, robot_log(log, robot, columns), kept, FmuRuns) for log in logs}
    for log, cost in costs.items():
        notes.append(f"on {log} {cost.sentence}")
    for note in notes:
        show(f"note: {note}")
    shares = {
        log: {"of": c.measured, "all_laws_percent": c.all_laws, "kept_percent": c.kept}
        for log, c in costs.items()
    }
    write_json(json_file, {"file": output, "notes": notes, "relative_error": shares})


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(",") if word.strip()]


def _numbers(text: str, option: str) -> list[int]:
    try:
        return [int(word) for word in _words(text)]
    except ValueError:
        raise pi.RobotError(f"{option} must be joint numbers such as 1,2, not {text!r}") from None
