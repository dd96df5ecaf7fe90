"""A robot as the nested tables of its file."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from flexmodels.coordinate import joint_name
from flexmodels.effects import BASE
from flexmodels.files.servo_table import servo_document
from flexmodels.joint import Joint
from flexmodels.loops.linkage import PassiveJoint
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing

_PREFIXES = ("stiffness", "damping")  # written as the arrays k and d


def document(robot: Robot, effect_names: Mapping[str, str]) -> dict[str, Any]:
    """What `flexmodels.files.robot_file` reads back as the same robot.

    effect_names   what each of the robot's effect files is called as seen from the robot file
    """
    document: dict[str, Any] = {
        "name": robot.name,
        "description": robot.description,
        "gravity": list(robot.gravity),
        "tip": list(robot.tip),
    }
    if robot.effect_files:
        document["effects"] = [effect_names[file] for file in robot.effect_files]
    if robot.controller:
        c = robot.controller
        document["controller"] = {"rate": c.rate, "Kp": list(c.Kp), "Kd": list(c.Kd), "Ki": list(c.Ki)}
    if robot.servo:
        document["servo"] = servo_document(robot.servo)
    if robot.settings.columns:
        document["columns"] = {
            s: c.source if c.gain == 1 else {"source": c.source, "gain": c.gain}
            for s, c in robot.settings.columns.items()
        }
    if robot.transmission:
        t = robot.transmission
        rows, own = [list(row) for row in t.ratio], [row[i] for i, row in enumerate(t.ratio)]
        coupled = any(v for i, row in enumerate(rows) for j, v in enumerate(row) if i != j)
        document["transmission"] = {"ratio": rows if coupled else own, "offset": list(t.offset)}
        if t.drive:
            document["transmission"]["drive"] = list(t.drive)
    if robot.settings.processing != Processing():
        p = robot.settings.processing
        document["processing"] = {key: v for key, v in asdict(p).items() if v is not None}
    if robot.settings.identification:
        document["identification"] = _plain(asdict(robot.settings.identification))
    if robot.settings.line:
        document["line"] = _plain(asdict(robot.settings.line))
    if robot.tip_link is not None:
        document["tip_link"] = robot.tip_link
    document["joint"] = [
        *(_joint_document(joint) for joint in robot.joints),
        *(_passive_document(joint) for joint in robot.passive),
    ]
    document["link"] = [{"m": link.m, "ms": list(link.ms), "J": list(link.J)} for link in robot.links]
    if robot.closures:
        document["closure"] = [_plain(asdict(closure)) for closure in robot.closures]
    return document


def _plain(value: Any) -> Any:
    """Tuples as lists, for TOML."""
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    return list(value) if isinstance(value, tuple) else value


def _place(joint: Joint | PassiveJoint) -> dict[str, Any]:
    parent = {} if joint.parent is None else {"parent": joint.parent}
    return parent | {"origin": list(joint.origin), "x": list(joint.x), "y": list(joint.y)}


def _passive_document(joint: PassiveJoint) -> dict[str, Any]:
    follows = {joint_name(k): factor for k, factor in joint.follows.items()}
    geared = {"geared": True} if joint.geared else {}
    return {"passive": True} | geared | _place(joint) | {"follows": follows}


def _joint_document(joint: Joint) -> dict[str, Any]:
    named = {"name": joint.name} if joint.name else {}
    table: dict[str, Any] = named | {"kind": joint.kind} | _place(joint)
    if joint.limits:
        table["limits"] = {key: _plain(v) for key, v in asdict(joint.limits).items() if v is not None}
    others = {}
    for effect, values in joint.values.items():
        if effect in _PREFIXES:
            table[next(iter(values))[0]] = list(values.values())
        elif effect in BASE:
            table |= values
        else:
            others[effect] = dict(values)
    if others:
        table["effects"] = others
    return table
