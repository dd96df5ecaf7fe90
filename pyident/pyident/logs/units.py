"""Units that logs come in, as factors to SI."""

from math import pi

from pyident.logs.log import LogError

_FACTORS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180, "rev": 2 * pi},
    "length": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "speed": {"rad/s": 1.0, "deg/s": pi / 180, "rpm": pi / 30, "m/s": 1.0, "mm/s": 1e-3},
    "effort": {
        "N.m": 1.0,
        "Nm": 1.0,
        "mN.m": 1e-3,
        "mNm": 1e-3,
        "kN.m": 1e3,
        "kNm": 1e3,
        "N": 1.0,
        "kN": 1e3,
    },
    "electric": {"A": 1.0, "mA": 1e-3, "V": 1.0, "mV": 1e-3},
    "none": {"1": 1.0, "%": 1e-2},
}
FACTORS = {unit: factor for group in _FACTORS.values() for unit, factor in group.items()}


def factor(unit: str, place: str) -> float:
    """SI units per `unit`. Raises LogError that names `place`."""
    if unit not in FACTORS:
        raise LogError(f"{place} = {unit!r} is not a known unit; known are {', '.join(FACTORS)}")
    return FACTORS[unit]
