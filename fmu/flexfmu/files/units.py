"""Units of FMI: their types and their powers of the SI base units."""

import re

_DERIVED = {
    "N": {"kg": 1, "m": 1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
}
TYPES = {
    "rad": "Angle",
    "rad/s": "AngularVelocity",
    "rad/s2": "AngularAcceleration",
    "m": "Length",
    "m/s": "Velocity",
    "m/s2": "Acceleration",
    "N": "Force",
    "N.m": "Torque",
    "kg": "Mass",
    "kg.m2": "MomentOfInertia",
    "N.m/rad": "RotationalSpringConstant",
    "N.m.s/rad": "RotationalDampingConstant",
    "s": "Time",
}


def base_units(unit: str) -> dict[str, int]:
    """Powers of the SI base units (and rad) in a unit such as `N.m/(rad.s)` or `kg.m2`."""
    powers: dict[str, int] = {}
    for side, text in zip((1, -1), unit.replace("(", "").replace(")", "").split("/"), strict=False):
        for symbol, exponent in re.findall(r"([A-Za-z]+)(\d*)", text):
            for base, power in _DERIVED.get(symbol, {symbol: 1}).items():
                powers[base] = powers.get(base, 0) + side * power * int(exponent or 1)
    return {base: power for base, power in powers.items() if power}
