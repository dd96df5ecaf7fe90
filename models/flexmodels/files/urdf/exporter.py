"""Robot -> URDF: the rigid tree, its flexible hinges locked."""

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from flexmodels.atomic import replacing
from flexmodels.coordinate import joint_name
from flexmodels.files.body_tree import centred
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot, RobotError

KEPT = frozenset({"coulomb", "viscous"})


def export_urdf(robot: Robot, path: str | Path) -> list[str]:
    """Write `robot` and return, a sentence each, what of it a URDF cannot say.

    Every frame is the triad of its joint, so each joint turns about (or moves along) its frame's x axis.
    Raises RobotError for closed loops and for a link that no rigid body could be.
    """
    if robot.passive or robot.closures:
        raise RobotError(f"robot {robot.name} has closed loops, which a URDF cannot hold; export an FMU")
    root = Element("robot", name=robot.name)
    SubElement(root, "link", name="base_link")
    triads = [np.eye(3), *(joint.triad for joint in robot.joints)]
    for (k, joint), parent in zip(robot.numbered, robot.parents, strict=True):
        _add_link(root, k, robot.links[k - 1], triads[k])
        _add_joint(root, k, joint, parent, triads[parent])
    last = len(robot.links) if robot.tip_link is None else robot.tip_link
    _add_tip(root, last, triads[last].T @ np.array(robot.tip))
    ElementTree.indent(root)
    with replacing(path) as file:
        ElementTree.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)
    return _left_out(robot)


def _add_link(root: Element, k: int, link: Link, triad: np.ndarray) -> None:
    element = SubElement(root, "link", name=f"link{k}")
    if not any(link.values.values()):
        return
    m, com, J = centred(link, k)
    J = triad.T @ J @ triad
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=_text(triad.T @ com), rpy="0 0 0")
    SubElement(inertial, "mass", value=repr(m))
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    values = {name: repr(float(v)) for name, v in zip(names, J[np.triu_indices(3)], strict=True)}
    SubElement(inertial, "inertia", values)


def _add_joint(root: Element, k: int, joint: Joint, parent: int, axes: np.ndarray) -> None:
    limits = joint.limits
    bounded = limits is not None and limits.position is not None
    kind = "prismatic" if joint.kind == "prismatic" else "revolute" if bounded else "continuous"
    element = SubElement(root, "joint", name=joint.name or joint_name(k), type=kind)
    turn = _roll_pitch_yaw(axes.T @ joint.triad)
    SubElement(element, "origin", xyz=_text(axes.T @ np.array(joint.origin)), rpy=_text(turn))
    SubElement(element, "parent", link=f"link{parent}" if parent else "base_link")
    SubElement(element, "child", link=f"link{k}")
    SubElement(element, "axis", xyz="1 0 0")
    friction = joint.values.get("coulomb", {}).get("coulomb", 0.0)
    damping = joint.values.get("viscous", {}).get("viscous", 0.0)
    SubElement(element, "dynamics", damping=repr(damping), friction=repr(friction))
    if limits is not None or kind == "prismatic":
        lower, upper = limits.position if limits is not None and limits.position else (0.0, 0.0)
        bounds = {} if kind == "continuous" else {"lower": repr(lower), "upper": repr(upper)}
        speed, effort = (limits.speed, limits.effort) if limits else (None, None)
        SubElement(element, "limit", bounds, velocity=repr(speed or 0.0), effort=repr(effort or 0.0))


def _add_tip(root: Element, link: int, place: np.ndarray) -> None:
    SubElement(root, "link", name="tip")
    element = SubElement(root, "joint", name="tip_joint", type="fixed")
    SubElement(element, "origin", xyz=_text(place), rpy="0 0 0")
    SubElement(element, "parent", link=f"link{link}")
    SubElement(element, "child", link="tip")


def _left_out(robot: Robot) -> list[str]:
    notes = []
    flexible = [str(k) for k, joint in robot.numbered if joint.flexible]
    if flexible:
        notes.append(f"the flexible hinges of joints {', '.join(flexible)} are locked: a URDF has none")
    laws = {law for joint in robot.joints for law, values in joint.values.items() if any(values.values())}
    others = sorted(laws - KEPT - {"stiffness", "damping"})
    if others:
        notes.append(f"a URDF has no place for {', '.join(others)}; they are left out")
    return notes


def _roll_pitch_yaw(R: np.ndarray) -> np.ndarray:
    """R = Rz(yaw) Ry(pitch) Rx(roll); the roll is what the others leave: exact at a pitch of 90° too."""
    yaw = np.arctan2(R[1, 0], R[0, 0])
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    y = np.array([-sy, cy, 0.0])
    z = np.array([cy * sp, sy * sp, cp])
    return np.array([np.arctan2(z @ R[:, 1], y @ R[:, 1]), pitch, yaw])


def _text(vector: np.ndarray) -> str:
    return " ".join(repr(float(v)) for v in vector)
