"""The JSON Schema of robot files: what editors complete and explain, and what the reader checks by.

It says what may stand where and in which unit; that lists fit each other, loops close and inertias are
possible, only the reader (`robot_file`) can say.
"""

from collections.abc import Mapping
from typing import Any

from flexmodels.effects import BASE, CATALOGUE
from flexmodels.effects.effect import Effect
from flexmodels.settings.servo import PER_JOINT, POSITIVE, SHARED

_AXES = {"minItems": 3, "maxItems": 3}
_SLOWEST, _FASTEST = 1e-3, 1e6  # [Hz] of a controller


def schema(own: Mapping[str, Effect] | None = None) -> dict[str, Any]:
    """The schema, draft 2020-12, with every effect of the catalogue and a robot's own."""
    laws = {**CATALOGUE, **(own or {})}
    tables = {
        "controller": _controller(),
        "servo": _servo(),
        "columns": {"type": "object", "additionalProperties": {"anyOf": [_text("Column"), _column()]}},
        "transmission": _transmission(),
        "processing": _processing(),
        "identification": _identification(),
        "line": _line(),
        "joint": _list({"anyOf": [_joint(laws), _passive()]}, "Driven joints, then passive ones"),
        "link": _list({"anyOf": [_link_at_joint(), _link_at_centre()]}, "One per joint, in their order"),
        "closure": _list(_closure(), "Pins that close loops"),
    }
    plain = {
        "name": _text("The robot's name"),
        "description": _text("A sentence or two"),
        "gravity": _vector("Acceleration of gravity in base axes [m/s2]; 0, 0, -9.81 if absent"),
        "tip": _vector("From the joint of the tip's link, in the zero pose [m]"),
        "tip_link": _whole("Number of the link that carries the tip; the last if absent", 1),
        "effects": {"type": "array", "items": {"type": "string"}, "description": "Python files of own laws"},
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Robot file of flexident",
        **_table(plain | tables, ("joint", "link")),
    }


def _joint(laws: Mapping[str, Effect]) -> dict[str, Any]:
    keys = {
        "name": _text("What others call it"),
        "kind": {"enum": ["revolute", "prismatic"], "description": "Turns about x or moves along it"},
        "passive": {"const": False, "description": "Whether it follows others; it does not if absent"},
        "k": _numbers("Stiffness of the flexible hinge: twist, or twist and both bendings [N m/rad]", 0),
        "d": _numbers("Its damping, as many numbers as k [N m s/rad]", 0),
        "limits": _limits(),
        "effects": _table({name: _effect(e) for name, e in laws.items() if not e.base}),
    }
    base = {
        p.name: _number(f"{effect.title} [{p.unit}]", p.lower)
        for effect in BASE.values()
        for p in effect.parameters
        if "[" not in p.name
    }
    return _table(_place() | keys | base, ("x", "y"))


def _passive() -> dict[str, Any]:
    follows = {
        "type": "object",
        "additionalProperties": {"type": "number"},
        "description": "joint1 = factor: its angle is the sum of factor times those of driven joints",
    }
    keys = {
        "passive": {"const": True},
        "follows": follows,
        "geared": {"type": "boolean", "description": "Turned by a gear or a belt; else pins make it follow"},
    }
    return _table(_place() | keys, ("passive", "x", "y", "follows"))


def _place() -> dict[str, Any]:
    return {
        "parent": _whole("Number of the link that it sits on, 0 for the base; the link before if absent", 0),
        "origin": _vector("From the joint of the parent link, in the zero pose [m]"),
        "x": _vector("Unit vector along the axis, in the zero pose"),
        "y": _vector("Unit vector at right angles to x"),
    }


def _effect(effect: Effect) -> dict[str, Any]:
    """A joint that does not bend needs fewer of the parameters, so that none is required here."""
    keys = {p.name: _number(f"[{p.unit}]", p.lower) for p in effect.parameters}
    return _table(keys) | {"description": f"{effect.title} ({effect.citation})"}


def _limits() -> dict[str, Any]:
    keys = {
        "position": _numbers("Lower and upper [rad or m]", None, 2),
        "speed": _number("[rad/s or m/s]", 0),
        "effort": _number("[N m or N]", 0),
    }
    return _table(keys)


def _link_at_joint() -> dict[str, Any]:
    keys = {
        "m": _number("Mass [kg]", 0),
        "ms": _vector("First moments about the joint [kg m]"),
        "J": _numbers("Inertia about the joint: xx, xy, xz, yy, yz, zz [kg m2]", None, 6),
    }
    return _table(keys, tuple(keys))


def _link_at_centre() -> dict[str, Any]:
    keys = {
        "m": _number("Mass [kg]", 0),
        "com": _vector("Centre of mass from the joint [m]"),
        "J_com": _numbers("Inertia about it: xx, yy, zz or xx, xy, xz, yy, yz, zz [kg m2]"),
    }
    return _table(keys, tuple(keys))


def _closure() -> dict[str, Any]:
    keys = {
        "links": _numbers("The rod and the link it is pinned to", 1, 2),
        "point": _vector("Of the pin, in the zero pose [m]"),
        "axis": _vector("Unit vector along the pin"),
    }
    return _table(keys, tuple(keys))


def _controller() -> dict[str, Any]:
    gains = {
        "Kp": _numbers("Proportional gain of each joint [N m/rad or N/m]"),
        "Kd": _numbers("Derivative gain [N m s/rad or N s/m]"),
        "Ki": _numbers("Integral gain [N m/(rad s) or N/(m s)]"),
    }
    return _table({"rate": _rate()} | gains, ("rate", *gains))


def _rate() -> dict[str, Any]:
    return _number("Samples a second [Hz]", _SLOWEST) | {"maximum": _FASTEST}


def _servo() -> dict[str, Any]:
    def size(text: str, name: str) -> dict[str, Any]:
        return _positive(text) if name in POSITIVE else _number(text, 0)

    each = {
        name: {
            "anyOf": [size(text, name), _numbers(text) | {"items": size("", name)}],
            "description": f"{text} [{unit}]",
        }
        for name, (unit, text) in PER_JOINT.items()
    }
    shared = {name: size(f"{text} [{unit}]", name) for name, (unit, text) in SHARED.items()}
    names = [*PER_JOINT, *SHARED]
    unknown = {"type": "array", "items": {"enum": names}, "description": "What identification may change"}
    keys = {"rate": _positive("Samples a second of the position loop [Hz]"), "unknown": unknown}
    required = ("rate", "supply", "kp", "gain", "kt", *sorted(POSITIVE))
    return _table(keys | each | shared, required)


def _column() -> dict[str, Any]:
    return _table({"source": _text("Column of the file"), "gain": _number("Factor to SI")}, ("source",))


def _transmission() -> dict[str, Any]:
    rows = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}
    keys = {
        "ratio": {"anyOf": [_numbers("Of each joint"), rows], "description": "Motor turns per joint turn"},
        "offset": _numbers("Joint angles where the motors read zero [rad or m]"),
        "drive": _numbers("Motor torque per unit of current [N m/A]"),
    }
    return _table(keys, ("ratio",))


def _processing() -> dict[str, Any]:
    keys = {
        "derivative": {"enum": ["central", "hat"], "description": "How positions become speeds"},
        "cutoff": _positive("Of the zero-phase Butterworth filter [Hz]"),
        "order": _whole("Of the filter", 1, 20),
        "decimate": _whole("Factor by which filtered equations are thinned out", 1, 1_000_000),
        "band": _positive("Up to which a diagnosis judges [Hz]"),
        "dead_zone": _number("Speed below which its sign is noise [rad/s or m/s]", 0),
    }
    return _table(keys)


def _identification() -> dict[str, Any]:
    sine = {
        "rms": _numbers("Torque of each joint [N m or N]", 0),
        "lines": _whole("Number of frequencies", 1, 100_000),
        "lowest": _positive("[Hz]"),
        "highest": _positive("[Hz]"),
    }
    keys = {
        "swing": _numbers("Of each joint [rad or m]"),
        "period": _positive("[s]"),
        "duration": _positive("[s]"),
        "multisine": _table(sine, tuple(sine)),
    }
    return _table(keys, tuple(keys))


def _line() -> dict[str, Any]:
    keys = {
        "start": _vector("Of the tip [m]"),
        "end": _vector("Of the tip [m]"),
        "duration": _positive("[s]"),
        "locked": {"type": "array", "items": {"type": "integer"}, "description": "Joints that stay at 0"},
    }
    return _table(keys, ("start", "end", "duration"))


def _table(keys: dict[str, Any], required: tuple[str, ...] = ()) -> dict[str, Any]:
    table = {"type": "object", "properties": keys, "additionalProperties": False}
    return table | ({"required": list(required)} if required else {})


def _list(item: dict[str, Any], text: str) -> dict[str, Any]:
    return {"type": "array", "minItems": 1, "items": item, "description": text}


def _text(text: str) -> dict[str, Any]:
    return {"type": "string", "description": text}


def _number(text: str, lower: float | None = None) -> dict[str, Any]:
    bound = {"minimum": lower} if lower is not None and lower > float("-inf") else {}
    return {"type": "number", "description": text} | bound


def _positive(text: str) -> dict[str, Any]:
    return {"type": "number", "description": text, "exclusiveMinimum": 0}


def _whole(text: str, lower: int, upper: int | None = None) -> dict[str, Any]:
    bound = {} if upper is None else {"maximum": upper}
    return {"type": "integer", "minimum": lower, "description": text} | bound


def _numbers(text: str, lower: float | None = None, size: int | None = None) -> dict[str, Any]:
    bounds = {"minItems": size, "maxItems": size} if size else {"minItems": 1}
    return {"type": "array", "items": _number("", lower), "description": text} | bounds


def _vector(text: str) -> dict[str, Any]:
    return {"type": "array", "items": {"type": "number"}, "description": text} | _AXES
