"""Robot -> MJCF: the tree with armature, damping, frictionloss, springs and servos, flexible hinges included.

Every body's axes are parallel to the base's in the zero pose. A flexible hinge becomes joints with springs in
the same body: its twist exactly, its bending to second order in the deformations.
"""

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from flexmodels.atomic import replacing
from flexmodels.files.body_tree import centred
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.loops.linkage import PassiveJoint
from flexmodels.robot import Robot, RobotError

KEPT = frozenset({"motor_inertia", "coulomb", "viscous", "stiffness", "damping", "joint_spring"})
_TIMESTEP = 0.001  # [s] where there is no controller
_LEAST_INERTIA = 1e-12  # [kg m2] about the centre of mass, of a point or a rod: MuJoCo refuses zero
_AXES = {1: ("x", 1.0), 2: ("z", 1.0), 3: ("y", -1.0)}  # about which triad axis eps[i] turns


def export_mjcf(robot: Robot, path: str | Path) -> list[str]:
    """Write `robot` and return, a sentence each, what of it an MJCF cannot say.

    Raises RobotError for closed loops and for a link that no rigid body could be.
    """
    if robot.closures:
        raise RobotError(f"robot {robot.name} has closed loops, which are not written as MJCF; export an FMU")
    root = Element("mujoco", model=robot.name)
    SubElement(root, "compiler", angle="radian", autolimits="true")
    step = robot.controller.period if robot.controller else _TIMESTEP
    SubElement(root, "option", timestep=repr(step), gravity=_text(robot.gravity), integrator="implicitfast")
    world = SubElement(root, "worldbody")
    for k in _children(robot, 0):
        _add_body(world, robot, k)
    _add_drives(root, robot)
    ElementTree.indent(root)
    with replacing(path) as file:
        ElementTree.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)
    return _left_out(robot)


def joint_name(robot: Robot, k: int) -> str:
    """What the joint of link k is called in the file."""
    joint = robot.joints[k - 1] if k <= len(robot.joints) else None
    return joint.name if joint is not None and joint.name else f"joint{k}"


def _joint(robot: Robot, k: int) -> Joint | PassiveJoint:
    return (*robot.joints, *robot.passive)[k - 1]


def _children(robot: Robot, k: int) -> list[int]:
    return [n for n, parent in enumerate(robot.parents, start=1) if parent == k]


def _add_body(parent: Element, robot: Robot, k: int) -> None:
    """Link k and what hangs on it; a link without mass shares its body with the next joint's."""
    chain = [k]
    while not any(robot.links[chain[-1] - 1].values.values()):
        behind = _children(robot, chain[-1])
        if len(behind) != 1:
            raise RobotError(f"link {chain[-1]} has no mass, which MuJoCo needs of every body; give it one")
        chain.append(behind[0])
    origins = np.array([_joint(robot, n).origin for n in chain])
    body = SubElement(parent, "body", name=f"link{chain[-1]}", pos=_text(origins.sum(axis=0)))
    for i, n in enumerate(chain):
        _add_joint(body, robot, n, -origins[i + 1 :].sum(axis=0))
    _add_inertial(body, chain[-1], robot.links[chain[-1] - 1])
    if chain[-1] == robot.last_link:
        SubElement(body, "site", name="tip", pos=_text(robot.tip))
    for n in _children(robot, chain[-1]):
        _add_body(body, robot, n)


def _add_joint(body: Element, robot: Robot, k: int, at: np.ndarray) -> None:
    joint = _joint(robot, k)
    place = {"pos": _text(at)}
    if isinstance(joint, PassiveJoint):
        SubElement(body, "joint", place, name=joint_name(robot, k), type="hinge", axis=_text(joint.x))
        return
    kind = "slide" if joint.kind == "prismatic" else "hinge"
    element = SubElement(body, "joint", place, name=joint_name(robot, k), type=kind, axis=_text(joint.x))
    for attribute, law, parameter in (
        ("armature", "motor_inertia", "J_m"),
        ("damping", "viscous", "viscous"),
        ("frictionloss", "coulomb", "coulomb"),
        ("stiffness", "joint_spring", "stiffness"),
    ):
        value = joint.values.get(law, {}).get(parameter, 0.0)
        if value:
            element.set(attribute, repr(value))
    spring = joint.values.get("joint_spring", {})
    if spring.get("stiffness"):
        element.set("springref", repr(-spring["preload"] / spring["stiffness"]))
    if joint.limits and joint.limits.position:
        element.set("range", _text(joint.limits.position))
    for name, attributes in _deformations(joint):
        SubElement(body, "joint", place | attributes, name=f"{joint_name(robot, k)}_{name}", type="hinge")


def _deformations(joint: Joint) -> Iterator[tuple[str, dict[str, str]]]:
    """Bend, then twist: the turn that comes last is nearest to the link."""
    axes = dict(zip("xyz", joint.triad.T, strict=True))
    for i in sorted(joint.deformations, key=lambda i: (2, 3, 1).index(i)):
        axis, sign = _AXES[i]
        stiffness = joint.values["stiffness"][f"k[{i}]"]
        damping = joint.values.get("damping", {}).get(f"d[{i}]", 0.0)
        yield (
            f"eps{i}",
            {"axis": _text(sign * axes[axis]), "stiffness": repr(stiffness), "damping": repr(damping)},
        )


def _add_inertial(body: Element, k: int, link: Link) -> None:
    m, com, J = centred(link, k)
    J = J + max(_LEAST_INERTIA - float(np.linalg.eigvalsh(J).min()), 0.0) * np.eye(3)
    full = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])
    SubElement(body, "inertial", pos=_text(com), mass=repr(m), fullinertia=_text(full))


def _add_drives(root: Element, robot: Robot) -> None:
    """A position servo per joint where there is a controller, else a motor; equalities for what follows."""
    actuators = SubElement(root, "actuator")
    for k, joint in robot.numbered:
        names = {"name": joint_name(robot, k), "joint": joint_name(robot, k)}
        effort = joint.limits.effort if joint.limits else None
        force = {"forcerange": _text((-effort, effort))} if effort else {}
        if robot.controller:
            gains = {"kp": repr(robot.controller.Kp[k - 1]), "kv": repr(robot.controller.Kd[k - 1])}
            SubElement(actuators, "position", names | gains | force)
        else:
            SubElement(actuators, "motor", names | force)
    if not robot.passive:
        return
    equality = SubElement(root, "equality")
    for k, passive in enumerate(robot.passive, start=len(robot.joints) + 1):
        if len(passive.follows) != 1 or any(robot.joints[n - 1].flexible for n in passive.follows):
            raise RobotError(f"joint {k} follows more than one hinge, which an MJCF equality cannot hold")
        ((leader, factor),) = passive.follows.items()
        pair = {"joint1": joint_name(robot, k), "joint2": joint_name(robot, leader)}
        SubElement(equality, "joint", pair, polycoef=f"0 {factor!r} 0 0 0")


def _left_out(robot: Robot) -> list[str]:
    notes = []
    bending = [str(k) for k, joint in robot.numbered if 2 in joint.deformations]
    if bending:
        notes.append(
            f"the bending of joints {', '.join(bending)} is written as two more hinges, right to second order"
        )
    laws = {law for joint in robot.joints for law, values in joint.values.items() if any(values.values())}
    if others := sorted(laws - KEPT):
        notes.append(f"an MJCF has no place for {', '.join(others)}; they are left out")
    if robot.controller and any(robot.controller.Ki):
        notes.append("the integral gains are left out: MuJoCo's position servo has none")
    if laws & {"coulomb"}:
        notes.append("MuJoCo softens frictionloss: a stuck joint creeps (solreffriction, solimpfriction)")
    return notes


def _text(vector) -> str:
    return " ".join(repr(float(v)) for v in vector)
