"""MJCF -> Robot: the tree as MuJoCo itself compiles it; chosen joints get a flexible hinge.

The zero pose is qpos = 0, so that e is MuJoCo's qpos. Bodies without joints are merged into the one that
carries them; what is fixed to the world does not move and is dropped. A free joint at the root is taken out:
the robot stands on a fixed base.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from flexmodels.files.body_tree import Body, lumped, plain, triad_along, with_hinges
from flexmodels.files.mjcf.drives import controller_of, couplings_of, left_out
from flexmodels.joint import Joint, Limits
from flexmodels.loops.linkage import PassiveJoint
from flexmodels.robot import Robot, RobotError

_MISSING = "MuJoCo is missing, which reads MJCF; pip install 'flexident[mujoco]'"


@dataclass(frozen=True)
class MjcfRobot:
    """A robot and, a sentence each, what of its file it does not hold."""

    robot: Robot
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Tree:
    """The compiled model at qpos = 0. number[j]: our joint of joint j of MuJoCo; carrier[b]: body -> link."""

    model: Any
    data: Any
    number: dict[int, int]
    carrier: list[int]
    parent: dict[int, int]  # our joint -> the link it sits on


def import_mjcf(path: str | Path, flexible: Iterable[int] = (), twist: Iterable[int] = ()) -> MjcfRobot:
    """The robot of an MJCF file, its driven joints in the order of the file, depth first.

    flexible  joints (from 1) that get a hinge which twists and bends;  twist   that only twist
    Armature, damping, frictionloss and spring of a joint become J_m, viscous, coulomb and `joint_spring`;
    motors and position servos the controller; joints tied by a linear equality follow their driven one. The
    tip is the last site on the last link that has one. Raises RobotError.
    """
    path = Path(path)
    model, data = _compiled(path)
    ties = couplings_of(model)
    tree = _numbered(model, data, ties)
    driven = [j for j, k in sorted(tree.number.items(), key=lambda item: item[1]) if j not in ties]
    if not driven:
        raise RobotError(f"{path}: there is no joint that moves; a robot needs one")
    joints = [_joint(tree, j) for j in driven]
    passive = []
    for j, (leader, factor) in ties.items():
        k = tree.number[leader]
        joints[k - 1] = _with_load(joints[k - 1], _laws(model, j), factor)
        passive.append(_passive(tree, j, {k: factor}))
    chain = not passive and all(joint.parent == k for k, joint in enumerate(joints))
    bodies = _bodies(tree)
    order = [*driven, *ties]
    places = [_anchor(tree, j) for j in order]
    tip_link, tip = _tip(tree, len(order))
    robot = Robot(
        name=_spec_name(path, model),
        joints=tuple(replace(j, parent=None) for j in joints) if chain else tuple(joints),
        links=tuple(lumped(b, at) for b, at in zip(bodies[1:], places, strict=True)),
        tip=plain(tip - places[tip_link - 1]),
        tip_link=None if tip_link == len(order) else tip_link,
        gravity=plain(model.opt.gravity),
        controller=controller_of(model, driven),
        description=f"imported from {path.name}",
        passive=tuple(passive),
    )
    places_of = [np.zeros(3), *places]
    return MjcfRobot(with_hinges(robot, list(flexible), list(twist), bodies, places_of), left_out(model))


def _compiled(path: Path) -> tuple[Any, Any]:
    try:
        mujoco: Any = import_module("mujoco")  # its stubs do not name what its binary holds
    except ImportError:
        raise RobotError(_MISSING) from None
    if not path.is_file():
        raise RobotError(f"there is no MJCF file {path}; check the path")
    mujoco.set_mju_user_warning(lambda _: None)  # else it writes MUJOCO_LOG.TXT where the command is called
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        _without_pictures(mujoco, spec)
        model = spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        text = " ".join(str(error).split())
        raise RobotError(f"{path} cannot be read as MJCF ({text}); correct the file") from None
    finally:
        mujoco.set_mju_user_warning(None)
    for j in range(model.njnt):
        if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_BALL:
            raise RobotError(f"joint {model.joint(j).name} is a ball; replace it by three hinges")
        if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE and model.body_parentid[model.jnt_bodyid[j]]:
            raise RobotError(f"joint {model.joint(j).name} is free but not at the root; remove it")
    data = mujoco.MjData(model)
    free = model.jnt_type == mujoco.mjtJoint.mjJNT_FREE
    start = data.qpos.copy()
    data.qpos[:] = 0.0
    for j in np.flatnonzero(free):
        at = model.jnt_qposadr[j]
        data.qpos[at : at + 7] = start[at : at + 7]
    mujoco.mj_kinematics(model, data)
    return model, data


def _without_pictures(mujoco: Any, spec: Any) -> None:
    """Meshes whose body has its inertia written down are pictures: their files need not be there."""
    meshes = [geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_MESH]
    for geom in meshes:
        if geom.parent.explicitinertial:
            spec.delete(geom)
    if all(geom.type != mujoco.mjtGeom.mjGEOM_MESH for geom in spec.geoms):
        for mesh in list(spec.meshes):
            spec.delete(mesh)


def _spec_name(path: Path, model: Any) -> str:
    name = model.names.split(b"\0")[0].decode(errors="replace")
    return name if name and name != "MuJoCo Model" else path.stem


def _numbered(model: Any, data: Any, ties: dict[int, tuple[int, float]]) -> _Tree:
    """Driven joints first, then those that follow; a body with several joints is a link per joint."""
    movable = [j for j in range(model.njnt) if model.jnt_type[j] in (2, 3)]
    order = [j for j in movable if j not in ties] + list(ties)
    number = {j: k for k, j in enumerate(order, start=1)}
    carrier, parent = [0] * model.nbody, {}
    for b in range(1, model.nbody):
        link = carrier[model.body_parentid[b]]
        first = model.body_jntadr[b]
        for j in range(first, first + model.body_jntnum[b]):
            if j not in number:
                continue
            parent[number[j]], link = link, number[j]
            if j not in ties and parent[number[j]] > len(order) - len(ties):
                raise RobotError(
                    f"joint {model.joint(j).name} sits on one that follows another; this is not read"
                )
        carrier[b] = link
    return _Tree(model, data, number, carrier, parent)


def _anchor(tree: _Tree, j: int) -> np.ndarray:
    return np.array(tree.data.xanchor[j])


def _place(tree: _Tree, j: int) -> dict[str, Any]:
    inverse = {k: i for i, k in tree.number.items()}
    before = tree.parent[tree.number[j]]
    base = _anchor(tree, inverse[before]) if before else np.zeros(3)
    triad = triad_along(np.array(tree.data.xaxis[j]), tree.model.joint(j).name)
    return {
        "x": plain(triad[:, 0]),
        "y": plain(triad[:, 1]),
        "origin": plain(_anchor(tree, j) - base),
        "parent": before,
    }


def _joint(tree: _Tree, j: int) -> Joint:
    m = tree.model
    position = plain(m.jnt_range[j]) if m.jnt_limited[j] else None
    effort = float(np.abs(m.jnt_actfrcrange[j]).max()) if m.jnt_actfrclimited[j] else _effort(m, j)
    return Joint(
        kind="prismatic" if m.jnt_type[j] == 2 else "revolute",
        flexible=False,
        values=_laws(m, j),
        name=m.joint(j).name,
        limits=Limits(position, None, effort) if position or effort else None,
        **_place(tree, j),
    )


def _passive(tree: _Tree, j: int, follows: dict[int, float]) -> PassiveJoint:
    if tree.model.jnt_type[j] == 2:
        raise RobotError(
            f"joint {tree.model.joint(j).name} is a slider that follows another; only hinges may: delete the "
            "equality that ties it, and it is a joint of its own, or the joint, and its body is fixed"
        )
    return PassiveJoint(follows=follows, geared=True, **_place(tree, j))


def _effort(m: Any, j: int) -> float | None:
    for a in range(m.nu):
        if m.actuator_trntype[a] == 0 and m.actuator_trnid[a][0] == j and m.actuator_forcelimited[a]:
            return float(abs(m.actuator_gear[a][0]) * np.abs(m.actuator_forcerange[a]).max())
    return None


def _laws(m: Any, j: int) -> dict[str, dict[str, float]]:
    dof = m.jnt_dofadr[j]
    laws = {
        "motor_inertia": {"J_m": float(m.dof_armature[dof])},
        "coulomb": {"coulomb": float(m.dof_frictionloss[dof])},
        "viscous": {"viscous": float(m.dof_damping[dof])},
    }
    stiffness = float(m.jnt_stiffness[j])
    if stiffness:
        rest = float(m.qpos_spring[m.jnt_qposadr[j]])
        laws["joint_spring"] = {"stiffness": stiffness, "preload": -stiffness * rest}
    return laws


def _with_load(joint: Joint, laws: dict[str, dict[str, float]], factor: float) -> Joint:
    """What a following joint takes, as the one that drives it feels it."""
    weight = {"J_m": factor**2, "viscous": factor**2, "coulomb": abs(factor)}
    weight |= {"stiffness": factor**2, "preload": factor}
    values = {name: dict(v) for name, v in joint.values.items()}
    for law, parameters in laws.items():
        own = values.setdefault(law, dict.fromkeys(parameters, 0.0))
        for name, value in parameters.items():
            own[name] += weight[name] * value
    return replace(joint, values=values)


def _bodies(tree: _Tree) -> list[list[Body]]:
    """(mass, centre, inertia about it) in base axes, per link; of link 0 they are the base's."""
    m, d = tree.model, tree.data
    bodies: list[list[Body]] = [[] for _ in range(len(tree.number) + 1)]
    for b in range(1, m.nbody):
        if m.body_mass[b] > 0:
            R = np.array(d.ximat[b]).reshape(3, 3)
            body = float(m.body_mass[b]), np.array(d.xipos[b]), R @ np.diag(m.body_inertia[b]) @ R.T
            bodies[tree.carrier[b]].append(body)
    return bodies


def _tip(tree: _Tree, links: int) -> tuple[int, np.ndarray]:
    m, d = tree.model, tree.data
    sites = [(tree.carrier[m.site_bodyid[s]], s) for s in range(m.nsite)]
    moving = [(link, s) for link, s in sites if link]
    if moving:
        link, s = max(moving)
        return link, np.array(d.site_xpos[s])
    last = max(b for b in range(m.nbody) if tree.carrier[b] == links)
    return links, np.array(d.xpos[last])
