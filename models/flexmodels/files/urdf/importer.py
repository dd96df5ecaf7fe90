"""URDF -> Robot: the rigid tree with its nominal inertias; chosen joints get a flexible hinge.

Fixed joints are merged into the link that carries them; the mass of the root does not move and is dropped.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]
from scipy.spatial.transform import Rotation
from urdf_parser_py import urdf
from urdf_parser_py.xml_reflection import core

from flexmodels.files.body_tree import Body, lumped, plain, triad_along, with_hinges
from flexmodels.files.urdf.check import check_urdf, require_few
from flexmodels.joint import Joint, Limits
from flexmodels.robot import Robot, RobotError

_UNUSED = ("visual", "collision", "material", "transmission", "gazebo", "sensor", "calibration")
_QUARTER, _ROUNDED = np.pi / 2, 1e-5  # rad: of a quarter turn that a file gives to five digits
_KINDS = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}


@dataclass
class _Frame:
    """Where a link of the file stands in the zero pose; `link` is ours that it is part of (0: the base)."""

    position: np.ndarray
    axes: np.ndarray
    link: int


@dataclass
class _Tree:
    """What was found so far; bodies[k] are (mass, centre, inertia about it) in base axes, of our link k."""

    joints: list[Joint] = field(default_factory=list)
    places: list[np.ndarray] = field(default_factory=lambda: [np.zeros(3)])
    bodies: list[list[Body]] = field(default_factory=lambda: [[]])
    ends: list[_Frame] = field(default_factory=list)


def import_urdf(
    path: str | Path, flexible: Iterable[int] = (), twist: Iterable[int] = (), fixed: Iterable[str] = ()
) -> Robot:
    """The robot of a URDF file, its driven joints in the order of the file's tree, depth first.

    flexible  joints (from 1) that get a hinge which twists and bends
    twist     joints that get a hinge which only twists
    fixed     names of joints that stand still at zero, such as a gripper's; those that mimic them do too
    The tip is the last frame on the last link. Stiffness and damping of the hinges are placeholders
    (10 Hz, 2 % of critical) until they are identified. Raises RobotError.
    """
    model = _parse(Path(path))
    _fix(model, set(fixed))
    tree = _Tree()
    _walk(model, tree)
    require_few(len(tree.joints))
    if not tree.joints:
        raise RobotError(f"{path}: there is no joint that moves; a robot needs one")
    tip = max(reversed(tree.ends), key=lambda end: end.link)
    chain = all(joint.parent == k for k, joint in enumerate(tree.joints))
    robot = Robot(
        name=model.name,
        joints=tuple(replace(j, parent=None) for j in tree.joints) if chain else tuple(tree.joints),
        links=tuple(lumped(b, at) for b, at in zip(tree.bodies[1:], tree.places[1:], strict=True)),
        tip=plain(tip.position - tree.places[tip.link]),
        tip_link=None if tip.link == len(tree.joints) else tip.link,
        description=f"imported from {Path(path).name}",
    )
    return with_hinges(robot, list(flexible), list(twist), tree.bodies, tree.places)


def _parse(path: Path) -> Any:
    if not path.is_file():
        raise RobotError(f"there is no URDF file {path}; check the path")
    complaints: list[str] = []
    core.on_error = complaints.append  # else it prints attributes that it does not know
    try:
        root = etree.parse(str(path)).getroot()
        check_urdf(root)
        etree.strip_elements(root, *_UNUSED, with_tail=False)
        model = urdf.Robot.from_xml_string(etree.tostring(root))
        model.get_root()
    except RobotError as error:
        raise RobotError(f"{path} cannot be read as URDF: {error}") from None
    except (etree.XMLSyntaxError, core.ParseError, AssertionError, ValueError, KeyError, TypeError) as error:
        what = (
            "a number that URDF requires is missing" if isinstance(error, TypeError) else str(error).strip()
        )
        first = (what or "it has no single root link").splitlines()
        raise RobotError(f"{path} cannot be read as URDF ({' '.join(first)}); correct the file") from None
    return model


def _fix(model: Any, names: set[str]) -> None:
    """Make joints, and those that mimic them, fixed ones."""
    for name in sorted(names - model.joint_map.keys()):
        raise RobotError(f"there is no joint {name} to be fixed; the file has {', '.join(model.joint_map)}")
    for joint in model.joints:
        if joint.name in names or (joint.mimic is not None and joint.mimic.joint in names):
            joint.type, joint.mimic = "fixed", None


def _walk(model: Any, tree: _Tree) -> None:
    """Add every link of the file, each before what hangs on it."""
    waiting: list[tuple[str, _Frame, Any]] = [(model.get_root(), _Frame(np.zeros(3), np.eye(3), 0), None)]
    while waiting:
        name, before, joint = waiting.pop()
        frame = before if joint is None else _behind(joint, before, tree)
        children = _add_link(model, name, frame, tree)
        waiting += [(child.child, frame, child) for child in reversed(children)]


def _behind(joint: Any, before: _Frame, tree: _Tree) -> _Frame:
    """The frame that a joint carries; one that moves is added."""
    shift, turn = _pose(joint.origin)
    position, axes = before.position + before.axes @ shift, before.axes @ turn
    if joint.type == "fixed":
        return _Frame(position, axes, before.link)
    tree.joints.append(_joint(joint, position - tree.places[before.link], axes, before.link))
    tree.places.append(position)
    tree.bodies.append([])
    return _Frame(position, axes, len(tree.joints))


def _add_link(model: Any, name: str, frame: _Frame, tree: _Tree) -> list[Any]:
    """Its body, and the joints that hang on it."""
    inertial = model.link_map[name].inertial
    if inertial is not None and inertial.mass:
        tree.bodies[frame.link].append(_body(inertial, frame))
    children = [model.joint_map[joint] for joint, _ in model.child_map.get(name, ())]
    if not children:
        tree.ends.append(frame)
    return children


def _body(inertial: Any, frame: _Frame) -> Body:
    shift, turn = _pose(inertial.origin)
    axes = frame.axes @ turn
    J = np.zeros((3, 3)) if inertial.inertia is None else np.array(inertial.inertia.to_matrix(), float)
    return float(inertial.mass), frame.position + frame.axes @ shift, axes @ J @ axes.T


def _joint(joint: Any, origin: np.ndarray, axes: np.ndarray, parent: int) -> Joint:
    if joint.type not in _KINDS:
        raise RobotError(
            f"joint {joint.name} is {joint.type}; only revolute, continuous, prismatic and fixed are read"
        )
    if joint.mimic is not None:
        raise RobotError(
            f"joint {joint.name} mimics {joint.mimic.joint}; fix both (--fixed {joint.mimic.joint}), "
            "or let a motor of its own drive it"
        )
    direction = (1, 0, 0) if joint.axis is None else joint.axis
    triad = axes @ triad_along(np.array(direction, float), joint.name)
    dynamics = joint.dynamics
    return Joint(
        kind=_KINDS[joint.type],  # pyright: ignore[reportArgumentType]
        x=plain(triad[:, 0]),
        y=plain(triad[:, 1]),
        origin=plain(origin),
        flexible=False,
        values={
            "motor_inertia": {"J_m": 0.0},
            "coulomb": {"coulomb": float((dynamics and dynamics.friction) or 0.0)},
            "viscous": {"viscous": float((dynamics and dynamics.damping) or 0.0)},
            "offset": {"offset": 0.0},
        },
        parent=parent,
        name=joint.name,
        limits=_limits(joint),
    )


def _limits(joint: Any) -> Limits | None:
    limit = joint.limit
    if limit is None:
        return None
    position = None if joint.type == "continuous" else (float(limit.lower), float(limit.upper))
    return Limits(position, _positive(limit.velocity), _positive(limit.effort))


def _positive(value: float | None) -> float | None:
    """URDF files write 0 where nothing is known."""
    return float(value) if value else None


def _exact(angle: float) -> float:
    """A quarter turn that a file has rounded; else axes that are parallel would be so but for 1e-10, and
    combinations of parameters told by that.
    """
    quarters = round(angle / _QUARTER) * _QUARTER
    return quarters if abs(angle - quarters) < _ROUNDED else angle


def _pose(origin: Any) -> tuple[np.ndarray, np.ndarray]:
    if origin is None:
        return np.zeros(3), np.eye(3)
    turn = Rotation.from_euler("xyz", [_exact(angle) for angle in origin.rpy or (0, 0, 0)]).as_matrix()
    return np.array(origin.xyz or (0, 0, 0), float), turn
