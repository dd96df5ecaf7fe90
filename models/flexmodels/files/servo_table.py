"""The [servo] table of a robot file."""

from typing import Any

from flexmodels.files.toml_table import Table
from flexmodels.robot import RobotError
from flexmodels.settings.servo import LONGEST_DELAY, PER_JOINT, POSITIVE, SHARED, Servo

_DEFAULTS = {"ki": 0.0, "kd": 0.0, "limit": 1.0, "dead_band": 0.0, "saturation": 0.0}


def read_servo(table: Table, joints: int) -> Servo:
    """A number for all joints, or one per joint. Raises RobotError."""
    values: dict[str, Any] = {name: _numbers(table, name, joints) for name in PER_JOINT}
    for name in sorted(POSITIVE):
        if min(values[name]) <= 0:
            raise RobotError(f"{table.place(name)} must be above 0")
    rate = table.number("rate", lower=0.0, above=True)
    delay = table.number("delay", 0.0, lower=0.0)
    if delay > LONGEST_DELAY / rate:
        raise RobotError(
            f"{table.place('delay')} = {delay:g} s is over {LONGEST_DELAY} samples of the servo; lower rate"
        )
    unknown = table.get("unknown", ())
    names = [*PER_JOINT, *SHARED]
    if not isinstance(unknown, list | tuple) or any(name not in names for name in unknown):
        raise RobotError(f"{table.place('unknown')} must list some of {', '.join(names)}")
    supply = table.number("supply", lower=0.0, above=True)
    table.done()
    return Servo(rate=rate, supply=supply, delay=delay, unknown=tuple(unknown), **values)


def _numbers(table: Table, name: str, joints: int) -> tuple[float, ...]:
    value = table.get(name, _DEFAULTS.get(name))
    if isinstance(value, list):
        return table.vector(name, joints, lower=0.0)
    return (table.number(name, _DEFAULTS.get(name), lower=0.0),) * joints


def servo_document(servo: Servo) -> dict[str, Any]:
    """What `read_servo` reads back."""
    table: dict[str, Any] = {"rate": servo.rate, "supply": servo.supply, "delay": servo.delay}
    table |= {name: list(getattr(servo, name)) for name in PER_JOINT}
    return table | ({"unknown": list(servo.unknown)} if servo.unknown else {})
