"""`--set NAME=VALUE` of every command that simulates."""

from collections.abc import Sequence
from math import isfinite

import click

from flexmodels.named_values import with_settings
from flexmodels.robot import Robot, RobotError

set_option = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="Another value of a parameter, such as joint1.coulomb=2 or servo.kp=400; repeatable.",
)


def parsed(settings: Sequence[str]) -> dict[str, float]:
    """The pairs as numbers by name. Raises RobotError."""
    values = {}
    for pair in settings:
        name, equals, text = pair.partition("=")
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not equals or not isfinite(value):
            raise RobotError(f"--set {pair}: write NAME=VALUE with a finite number, as in servo.kp=400")
        values[name.strip()] = value
    return values


def with_set(robot: Robot, settings: Sequence[str]) -> Robot:
    """The robot with the values of `--set`. Raises RobotError."""
    return with_settings(robot, parsed(settings))
