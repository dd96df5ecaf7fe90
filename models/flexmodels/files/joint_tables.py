"""The [[joint]] and [[closure]] tables of a robot file."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.effects import BASE
from flexmodels.effects.effect import Effect
from flexmodels.effects.restriction import objection
from flexmodels.files.toml_table import Table
from flexmodels.joint import Joint, Limits
from flexmodels.loops.linkage import Closure, PassiveJoint
from flexmodels.robot import RobotError

_BASE_PARAMETERS = {p.name: e for e in BASE.values() for p in e.parameters if "[" not in p.name}


def require_order(data: Mapping[str, Any]) -> None:
    """Raises RobotError where a passive joint of a file stands before a driven one."""
    listed = data.get("joint")
    tables = listed if isinstance(listed, list) else []
    passive = [isinstance(table, Mapping) and table.get("passive") is True for table in tables]
    for k, one in enumerate(passive):
        if one and not all(passive[k:]):
            raise RobotError(f"joint[{k + 1}] is passive but stands before a driven one; list it after them")


def read_joints(
    tables: list[Table], own: Mapping[str, Effect]
) -> tuple[tuple[Joint, ...], tuple[PassiveJoint, ...]]:
    """Driven joints, then passive ones. Raises RobotError."""
    driven = [table for table in tables if not table.flag("passive")]
    joints = tuple(_joint(table, k, len(driven), own) for k, table in enumerate(driven, start=1))
    rest = enumerate(tables[len(driven) :], start=len(driven) + 1)
    return joints, tuple(_passive(table, k, joints) for k, table in rest)


def read_closures(tables: list[Table], links: int) -> tuple[Closure, ...]:
    """The pins of the tables [[closure]], between two of so many links. Raises RobotError."""
    return tuple(_closure(table, links) for table in tables)


def _joint(table: Table, k: int, joints: int, own: Mapping[str, Effect]) -> Joint:
    kind = table.get("kind", "revolute")
    x, y = _axes(table)
    hinge = _hinge_values(table)
    if "damping" in hinge and "stiffness" not in hinge:
        raise RobotError(f"{table.place('d')} needs {table.place('k')}")
    if len({len(values) for values in hinge.values()}) > 1:
        raise RobotError(f"{table.place('d')} must have as many numbers as {table.place('k')}")
    joint = Joint(
        kind=kind,
        x=x,
        y=y,
        origin=table.vector("origin", 3, (0.0, 0.0, 0.0)),
        flexible="stiffness" in hinge,
        values={},
        bends=len(hinge.get("stiffness", "bends")) != 1,
        parent=_parent(table, k),
        name=table.text("name") if "name" in table else "",
        limits=_limits(table.table("limits")) if "limits" in table else None,
        own=own,
    )
    if joint.kind == "prismatic" and hinge and not joint.bends:
        raise RobotError(
            f"{table.place('k')} would let a slider turn about its axis, not stretch: a belt or a spindle "
            "that gives way is not among the models here; give no k, or three for a carriage that tilts"
        )
    return replace(joint, values=hinge | _laws(table, joint, k, joints))


def _limits(table: Table) -> Limits:
    limits = Limits(
        position=table.vector("position", 2) if "position" in table else None,
        speed=table.number("speed") if "speed" in table else None,
        effort=table.number("effort") if "effort" in table else None,
    )
    if limits.position and limits.position[0] > limits.position[1]:
        raise RobotError(f"{table.place('position')} must be [lower, upper]")
    return limits


def _hinge_values(table: Table) -> dict[str, dict[str, float]]:
    """k and d: three numbers, or one for a hinge that only twists."""
    values: dict[str, dict[str, float]] = {}
    for key, effect in (("k", "stiffness"), ("d", "damping")):
        if key in table:
            given = table.get(key)
            numbers = table.vector(key, 1 if isinstance(given, list) and len(given) == 1 else 3)
            values[effect] = {f"{key}[{i + 1}]": v for i, v in enumerate(numbers)}
    return values


def _laws(table: Table, joint: Joint, k: int, joints: int) -> dict[str, dict[str, float]]:
    values: dict[str, dict[str, float]] = {}
    for name, effect in _BASE_PARAMETERS.items():
        if name in table:
            values.setdefault(effect.name, {})[name] = table.number(name)
    if "effects" in table:
        effects = table.table("effects")
        for name in effects.data:
            values[name] = _effect_values(effects, name, joint, k, joints)
    return values


def _effect_values(effects: Table, name: str, joint: Joint, k: int, joints: int) -> dict[str, float]:
    wrong = objection(joint.catalogue[name], joint.deformations, joint.kind, k, joints)
    if wrong:
        raise RobotError(f"{effects.place(name)} {wrong}")
    table = effects.table(name)
    values = {p.name: table.number(p.name) for p in joint.law(name).parameters}
    table.done()
    return values


def _passive(table: Table, k: int, joints: tuple[Joint, ...]) -> PassiveJoint:
    x, y = _axes(table)
    follows = table.table("follows")
    factors = {_followed(follows, name, joints): follows.number(name) for name in follows.data}
    return PassiveJoint(
        x=x,
        y=y,
        origin=table.vector("origin", 3, (0.0, 0.0, 0.0)),
        follows=factors,
        parent=_parent(table, k),
        geared=table.flag("geared"),
    )


def _followed(follows: Table, name: str, joints: tuple[Joint, ...]) -> int:
    """The number of a driven joint that a passive one may follow."""
    numbers = {joint_name(k): k for k in range(1, len(joints) + 1)}
    if name not in numbers:
        raise RobotError(f"{follows.place(name)} is no driven joint; they are joint1 to joint{len(joints)}")
    k = numbers[name]
    if joints[k - 1].kind == "prismatic" or 2 in joints[k - 1].deformations:
        raise RobotError(f"{follows.place(name)} must be a hinge that does not bend; give it k = [k1]")
    return k


def _closure(table: Table, links: int) -> Closure:
    a, b = (table.whole(v, f"links[{i + 1}]", 1, links) for i, v in enumerate(table.vector("links", 2)))
    axis = table.vector("axis", 3)
    if a == b:
        raise RobotError(f"{table.place('links')} must be two different links")
    if abs(np.linalg.norm(axis) - 1) > 1e-9:
        raise RobotError(f"{table.place('axis')} must be a unit vector")
    return Closure(links=(a, b), point=table.vector("point", 3), axis=axis)


def _axes(table: Table) -> tuple[tuple[float, ...], tuple[float, ...]]:
    x, y = table.vector("x", 3), table.vector("y", 3)
    if abs(np.linalg.norm(x) - 1) > 1e-9 or abs(np.linalg.norm(y) - 1) > 1e-9 or abs(np.dot(x, y)) > 1e-9:
        raise RobotError(f"{table.place('x')} and y must be unit vectors at right angles")
    return x, y


def _parent(table: Table, k: int) -> int | None:
    if "parent" not in table:
        return None
    return table.whole(table.get("parent"), "parent", 0, k - 1)
