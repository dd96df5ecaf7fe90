"""The [servo] table of a robot file."""

from typing import Any

from flexmodels.files.toml_table import Table
from flexmodels.robot import RobotError
from flexmodels.settings.servo import LONGEST_DELAY, PER_JOINT, Servo

_DEFAULTS = {"ki": 0.0, "kd": 0.0, "limit": 1.0, "dead_band": 0.0, "saturation": 0.0}


def read_servo(table: Table, joints: int) -> Servo:
    """A number for all joints, or one per joint. Raises RobotError."""
    values: dict[str, Any] = {name: _numbers(table, name, joints) for name in PER_JOINT}
    rate, delay = table.number("rate"), table.number("delay", 0.0)
    if delay > LONGEST_DELAY / rate:
        raise RobotError(
            f"{table.place('delay')} = {delay:g} s is over {LONGEST_DELAY} samples of the servo; lower rate"
        )
    unknown = tuple(table.get("unknown", ()))
    return Servo(rate=rate, supply=table.number("supply"), delay=delay, unknown=unknown, **values)


def _numbers(table: Table, name: str, joints: int) -> tuple[float, ...]:
    value = table.get(name, _DEFAULTS.get(name))
    if isinstance(value, list):
        return table.vector(name, joints)
    return (table.number(name, _DEFAULTS.get(name)),) * joints


def servo_document(servo: Servo) -> dict[str, Any]:
    """What `read_servo` reads back."""
    table: dict[str, Any] = {"rate": servo.rate, "supply": servo.supply, "delay": servo.delay}
    table |= {name: list(getattr(servo, name)) for name in PER_JOINT}
    return table | ({"unknown": list(servo.unknown)} if servo.unknown else {})
