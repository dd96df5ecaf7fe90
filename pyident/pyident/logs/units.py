"""Units that logs come in, as factors to SI."""

import re
from math import pi

from pyident.logs.log import LogError

_FACTORS = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180, "rev": 2 * pi},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254},
    "speed": {
        "rad/s": 1.0,
        "deg/s": pi / 180,
        "rev/s": 2 * pi,
        "rpm": pi / 30,
        "m/s": 1.0,
        "mm/s": 1e-3,
    },
    "effort": {
        "N.m": 1.0,
        "Nm": 1.0,
        "mN.m": 1e-3,
        "mNm": 1e-3,
        "kN.m": 1e3,
        "kNm": 1e3,
        "N.cm": 1e-2,
        "Ncm": 1e-2,
        "N.mm": 1e-3,
        "Nmm": 1e-3,
        "kgf.m": 9.80665,
        "kgf.cm": 9.80665e-2,
        "lbf.ft": 4.4482216152605 * 0.3048,
        "lbf.in": 4.4482216152605 * 0.0254,
        "N": 1.0,
        "kN": 1e3,
    },
    "electric": {"A": 1.0, "mA": 1e-3, "V": 1.0, "mV": 1e-3},
    "none": {"1": 1.0, "%": 1e-2, "‰": 1e-3},
}
FACTORS = {unit: factor for group in _FACTORS.values() for unit, factor in group.items()}


RATED = ("%", "‰")  # in which a torque or a current is part of a rated one


def factor(unit: str, place: str) -> float:
    """SI units per `unit`. Raises LogError that names `place`."""
    if unit not in FACTORS:
        raise LogError(f"{place} = {unit!r} is not a known unit; known are {', '.join(FACTORS)}")
    return FACTORS[unit]


KINDS = {unit: kind for kind, group in _FACTORS.items() for unit in group}
_PLAIN = {"Nm": "N.m", "mNm": "mN.m", "kNm": "kN.m", "Ncm": "N.cm", "Nmm": "N.mm"}
_SPELLINGS = {
    "°": "deg", "º": "deg", "degree": "deg", "degrees": "deg", "grad": "deg", "grd": "deg",
    "radian": "rad", "radians": "rad",
    "°/s": "deg/s", "º/s": "deg/s", "dps": "deg/s", "grad/s": "deg/s", "grd/s": "deg/s",
    "rad/sec": "rad/s", "deg/sec": "deg/s", "1/min": "rpm",
    "u/min": "rpm", "min-1": "rpm", "µs": "us", "μs": "us", "sec": "s", "seconds": "s", "msec": "ms",
    "n*m": "N.m", "n·m": "N.m", "n m": "N.m", "nm": "N.m", "n.m": "N.m", "newton-metre": "N.m",
    "mn*m": "mN.m", "mn·m": "mN.m", "mn m": "mN.m", "mnm": "mN.m", "kn*m": "kN.m", "kn·m": "kN.m",
    "kn m": "kN.m", "knm": "kN.m", "ncm": "N.cm", "n cm": "N.cm",
    "n*mm": "N.mm", "n mm": "N.mm", "ft-lb": "lbf.ft", "ft.lb": "lbf.ft",
    "ftlb": "lbf.ft", "in-lb": "lbf.in", "kgcm": "kgf.cm", "kg.cm": "kgf.cm", "µm": "um", "turn": "rev",
    "turns": "rev", "amp": "A", "amps": "A", "ampere": "A", "volt": "V", "volts": "V",
    "percent": "%", "pct": "%", "prozent": "%", "permille": "‰", "per mille": "‰", "promille": "‰",
    "0.1%": "‰", "0.1 %": "‰", "0,1%": "‰", "0,1 %": "‰",
}  # fmt: skip


def known_unit(text: str) -> str | None:
    """Our spelling of a unit as other people write it, None where it is none."""
    text = text.strip().strip("[]()").strip()
    if text in _PLAIN:
        return _PLAIN[text]
    if text in FACTORS:
        return text if text != "1" else None
    low = text.lower()
    return _SPELLINGS.get(low) or next(
        (unit for unit in FACTORS if unit.lower() == low and unit != "1"), None
    )


_IN_NAME = re.compile(r"^(.*?)\s*[\[(]\s*([^\[\]()]+?)\s*[\])]\s*$")


def without_unit(name: str) -> tuple[str, str]:
    """A column's name and the unit that it ends with in brackets (A1_ist[grd]); as it is without one."""
    parts = _IN_NAME.match(name)
    unit = parts[2] if parts and known_unit(parts[2]) else ""
    return (parts[1], unit) if parts and unit else (name, "")
