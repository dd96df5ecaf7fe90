"""`pyident robots`: what ships, and robots from and to other people's files."""

import click
from rich.table import Table

from flexmodels.files.robot_file import load_robot, save_robot, shipped
from flexmodels.files.urdf_export import export_urdf
from flexmodels.files.urdf_import import import_urdf
from flexmodels.robot import RobotError
from pyident.cli.outputs import ROBOT, URDF
from pyident.cli.shared import console, effects_option, json_option, output_option, reported, write_json


@click.group(invoke_without_command=True)
@click.pass_context
@json_option
@reported
def robots(context: click.Context, json_file: str | None) -> None:
    """List the robots that ship; import and export others.

    Example: pyident robots
    """
    if context.invoked_subcommand is None:
        _list(json_file)


def _list(json_file: str | None) -> None:
    listed = {name: load_robot(file) for name, file in shipped().items()}
    table = Table("robot", "joints", "parameters", "description")
    for name, robot in listed.items():
        table.add_row(name, str(len(robot.joints)), str(len(robot.parameters)), robot.description)
    console.print(table)
    write_json(json_file, {name: robot.description for name, robot in listed.items()})


@robots.command(name="import")
@click.argument("urdf")
@output_option(ROBOT)
@click.option("--flexible", default="", metavar="K,...", help="Joints that twist and bend.")
@click.option("--twist", default="", metavar="K,...", help="Joints that only twist.")
@json_option
@reported
def import_command(urdf: str, output: str, flexible: str, twist: str, json_file: str | None) -> None:
    """Write the robot of a URDF as a robot file.

    Example: pyident robots import arm.urdf -o arm.toml --flexible 1,2 --twist 3
    """
    robot = import_urdf(urdf, _numbers(flexible, "--flexible"), _numbers(twist, "--twist"))
    save_robot(robot, output)
    names = ", ".join(f"{k} {joint.name}" for k, joint in robot.numbered)
    click.echo(f"wrote {output}: joints {names}")
    write_json(json_file, {"robot": output, "joints": [joint.name for joint in robot.joints]})


@robots.command(name="export")
@click.argument("model")
@output_option(URDF)
@effects_option
@json_option
@reported
def export_command(model: str, output: str, json_file: str | None) -> None:
    """Write the rigid part of MODEL as a URDF.

    Example: pyident robots export identified.toml -o identified.urdf
    """
    notes = export_urdf(load_robot(model), output)
    click.echo(f"wrote {output}")
    for note in notes:
        click.echo(f"note: {note}")
    write_json(json_file, {"urdf": output, "notes": notes})


def _numbers(text: str, option: str) -> list[int]:
    try:
        return [int(word) for word in text.split(",") if word.strip()]
    except ValueError:
        raise RobotError(f"{option} must be joint numbers such as 1,2, not {text!r}") from None
