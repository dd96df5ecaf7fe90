"""Rigid-body mechanics of a tree of links in CasADi: kinematics, inverse dynamics (Newton-Euler).

Recursions in link axes with 6-vectors [angular; linear] (Featherstone, Rigid Body Dynamics Algorithms,
2008: RNEA table 5.1). Deliberately not the finite elements of pyident: that both agree is
a test. Motor inertias are not in here; they enter as armature of the motor coordinates.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from flexmodels.coordinate import deformation_of, motor_of
from flexmodels.joint import Joint
from flexmodels.link import LINK_PARAMETERS
from flexmodels.loops.linkage import PassiveJoint
from flexmodels.mechanics import quaternions
from flexmodels.robot import Robot

SX = Any  # casadi.SX; its stubs do not describe operators


@dataclass(frozen=True)
class Hinge:
    """One joint of the recursion: a frame that moves relative to its parent's.

    parent       place of the hinge that it sits on, which stands before it; None for the base
    coordinates  indices into the tree's coordinates
    E            3 x 3, child axes to parent axes
    r            3, child origin in parent axes
    S            6 x m motion subspace in child axes;  c  6, its rate times the speeds
    inertia      6 x 6 about the child's origin, None for a massless frame
    turn         quaternion of E (x, y, z, w)
    """

    parent: int | None
    coordinates: list[int]
    E: SX
    r: SX
    S: SX
    c: SX
    inertia: SX | None
    turn: SX


@dataclass(frozen=True)
class Mechanism:
    """Symbols and hinges of a robot.

    q, v     n: e of every driven joint, then every eps, and their rates
    tree     (n + passive) x n: the tree's coordinates, with the angles of passive joints, are tree @ q
    bodies   10 x links: the lumped parameters of eq. (1), a column per link
    tip      from the frame of hinge `tip_hinge` [m]
    """

    q: SX
    v: SX
    tree: ca.DM
    bodies: SX
    hinges: tuple[Hinge, ...]
    gravity: np.ndarray
    tip: np.ndarray
    tip_hinge: int | None


def mechanism(robot: Robot) -> Mechanism:
    """The robot's hinges, parents first: per joint the motor hinge, then the flexible one."""
    names, n = robot.coordinates, len(robot.coordinates)
    q, v = ca.SX.sym("q", n), ca.SX.sym("v", n)
    bodies = ca.SX.sym("bodies", len(LINK_PARAMETERS), len(robot.links))
    hinges: list[Hinge] = []
    ends: list[int | None] = [None]  # last hinge of the base and of every link
    for k, joint in robot.numbered:
        parent, body = ends[robot.parents[k - 1]], _inertia(bodies[:, k - 1])
        i = names.index(motor_of(k))
        motor = _turning_hinge if joint.kind == "revolute" else _slider
        hinges.append(motor(joint, parent, i, q[i], None if joint.flexible else body))
        if joint.flexible:
            at = [names.index(deformation_of(k, i)) for i in joint.deformations]
            hinges.append(_flexible_hinge(joint, len(hinges) - 1, at, q[at], v[at], body))
        ends.append(len(hinges) - 1)
    tree = ca.sparsify(ca.DM(np.vstack([np.eye(n), robot.following])))
    for i, (joint, angle) in enumerate(zip(robot.passive, ca.vertsplit(tree @ q)[n:], strict=True)):
        k = len(robot.joints) + i
        hinges.append(_turning_hinge(joint, ends[robot.parents[k]], n + i, angle, _inertia(bodies[:, k])))
        ends.append(len(hinges) - 1)
    tip_hinge = ends[len(robot.links) if robot.tip_link is None else robot.tip_link]
    return Mechanism(
        q, v, tree, bodies, tuple(hinges), np.array(robot.gravity), np.array(robot.tip), tip_hinge
    )


def inverse_dynamics(m: Mechanism, a: SX) -> SX:
    """Generalised forces for accelerations `a` [n], without motor inertia: M(q) a + h(q, v).

    What the passive joints of the tree would need is put upon the coordinates that they follow.
    """
    a = m.tree @ a
    force, moving = ca.SX.zeros(a.numel()), motions(m)
    accelerations, wrenches = [], []
    for hinge, (X, velocity, bias) in zip(m.hinges, moving, strict=True):
        before = base_acceleration(m) if hinge.parent is None else accelerations[hinge.parent]
        accelerations.append(X @ before + bias + hinge.S @ a[hinge.coordinates])
        wrenches.append(wrench(hinge, velocity, accelerations[-1]))
    for i in reversed(range(len(m.hinges))):
        hinge, (X, _, _) = m.hinges[i], moving[i]
        force[hinge.coordinates] = hinge.S.T @ wrenches[i]
        if hinge.parent is not None:
            wrenches[hinge.parent] = wrenches[hinge.parent] + X.T @ wrenches[i]
    return m.tree.T @ force


def tip_position(m: Mechanism) -> SX:
    """Position of the tip in base axes [m]."""
    position, at = ca.SX(m.tip), m.tip_hinge
    while at is not None:
        hinge = m.hinges[at]
        position, at = hinge.r + hinge.E @ position, hinge.parent
    return position


def tip_motion(m: Mechanism) -> tuple[SX, SX, SX]:
    """Of the tip in base axes: velocity [m/s], orientation (x, y, z, w), angular velocity [rad/s]."""
    if m.tip_hinge is None:
        return ca.SX.zeros(3), quaternions.NONE, ca.SX.zeros(3)
    _, motion, _ = motions(m)[m.tip_hinge]
    spin, at = motion[:3], m.tip_hinge
    velocity, turn = motion[3:] + ca.cross(spin, ca.SX(m.tip)), quaternions.NONE
    while at is not None:
        hinge = m.hinges[at]
        velocity, spin = hinge.E @ velocity, hinge.E @ spin
        turn, at = quaternions.product(hinge.turn, turn), hinge.parent
    return velocity, turn, spin


def skeleton(m: Mechanism) -> SX:
    """Lines from hinge to hinge and to the tip in base axes, 3 x 2 lines: start, end, start, ... [m]."""
    frames: list[tuple[SX, SX]] = []  # origin, axes
    columns = []
    for hinge in m.hinges:
        origin, axes = (ca.SX.zeros(3), ca.SX.eye(3)) if hinge.parent is None else frames[hinge.parent]
        frames.append((origin + axes @ hinge.r, axes @ hinge.E))
        columns += [origin, frames[-1][0]]
    origin = frames[m.tip_hinge][0] if m.tip_hinge is not None else ca.SX.zeros(3)
    return ca.horzcat(*columns, origin, tip_position(m))


def motions(m: Mechanism) -> list[tuple[SX, SX, SX]]:
    """Per hinge: motion transform from the parent, velocity, velocity-product acceleration."""
    v, out = m.tree @ m.v, []
    for hinge in m.hinges:
        X = motion_transform(hinge)
        relative = hinge.S @ v[hinge.coordinates]
        velocity = relative if hinge.parent is None else X @ out[hinge.parent][1] + relative
        out.append((X, velocity, hinge.c + _cross_motion(velocity, relative)))
    return out


def base_acceleration(m: Mechanism) -> SX:
    """Gravity as an upward acceleration of the base."""
    return ca.vertcat(ca.SX.zeros(3), -m.gravity)


def motion_transform(hinge: Hinge) -> SX:
    """(6, 6): a spatial motion (angular, then linear) of the parent's frame in that of the hinge.

    Featherstone 2008, Rigid Body Dynamics Algorithms, chapter 2.
    """
    Et = hinge.E.T
    return ca.blockcat([[Et, ca.SX.zeros(3, 3)], [-Et @ ca.skew(hinge.r), Et]])


def _cross_motion(a: SX, b: SX) -> SX:
    w, v = a[:3], a[3:]
    return ca.vertcat(ca.cross(w, b[:3]), ca.cross(w, b[3:]) + ca.cross(v, b[:3]))


def wrench(hinge: Hinge, velocity: SX, acceleration: SX) -> SX:
    """Newton-Euler force of the frame's body: I a + v x* I v."""
    if hinge.inertia is None:
        return ca.SX.zeros(6)
    momentum = hinge.inertia @ velocity
    w, v, L, p = velocity[:3], velocity[3:], momentum[:3], momentum[3:]
    gyroscopic = ca.vertcat(ca.cross(w, L) + ca.cross(v, p), ca.cross(w, p))
    return hinge.inertia @ acceleration + gyroscopic


def _inertia(body: SX) -> SX:
    m, ms = body[0], body[1:4]
    xx, xy, xz, yy, yz, zz = (body[i] for i in range(4, 10))
    J = ca.blockcat([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return ca.blockcat([[J, ca.skew(ms)], [-ca.skew(ms), m * ca.SX.eye(3)]])


def _turning_hinge(joint: Joint | PassiveJoint, parent: int | None, i: int, e: SX, body: SX | None) -> Hinge:
    x = joint.triad[:, 0]
    r, S = ca.SX(joint.origin), ca.SX(np.r_[x, 0, 0, 0])
    return Hinge(parent, [i], _rotation(x, e), r, S, ca.SX.zeros(6), body, quaternions.about(x, e))


def _slider(joint: Joint, parent: int | None, i: int, e: SX, body: SX | None) -> Hinge:
    x = joint.triad[:, 0]
    r, S = np.array(joint.origin) + x * e, ca.SX(np.r_[0, 0, 0, x])
    return Hinge(parent, [i], ca.SX.eye(3), r, S, ca.SX.zeros(6), body, quaternions.NONE)


def _rotation(x: np.ndarray, e: SX) -> SX:
    along = np.outer(x, x)
    return along + ca.cos(e) * (np.eye(3) - along) + ca.sin(e) * ca.skew(x)


def _flexible_hinge(joint: Joint, parent: int, at: list[int], eps: SX, deps: SX, body: SX) -> Hinge:
    """Bend, then twist: x' goes to (c, eps2, eps3) by the shortest rotation, then eps1 about the new x'."""
    triad = joint.triad
    if len(at) == 1:
        x = triad[:, 0]
        S = ca.SX(np.r_[x, 0, 0, 0])
        turn = quaternions.about(x, eps)
        return Hinge(parent, at, _rotation(x, eps), ca.SX.zeros(3), S, ca.SX.zeros(6), body, turn)
    bend = ca.SX.sym("bend", 2)
    c = ca.sqrt(1 - ca.sumsqr(bend))
    shear = -bend[0] * bend[1] / (1 + c)
    B = ca.blockcat(
        [
            [c, -bend[0], -bend[1]],
            [bend[0], 1 - bend[0] ** 2 / (1 + c), shear],
            [bend[1], shear, 1 - bend[1] ** 2 / (1 + c)],
        ]
    )
    bendings = [_vee(ca.reshape(ca.jacobian(ca.vec(B), bend[i]), 3, 3) @ B.T) for i in (0, 1)]
    S_parent = ca.horzcat(B[:, 0], *bendings)
    rate = ca.SX.sym("rate", 3)
    S_dot = ca.jtimes(S_parent @ rate, bend, rate[1:])
    B, S_parent, S_dot = ca.substitute([B, S_parent, S_dot], [bend, rate], [eps[1:], deps])
    cos, sin = ca.cos(eps[0]), ca.sin(eps[0])
    twist = ca.blockcat([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
    E = triad @ (B @ twist) @ triad.T
    S = ca.vertcat(E.T @ (triad @ S_parent), ca.SX.zeros(3, 3))
    bias = ca.vertcat(E.T @ (triad @ S_dot), ca.SX.zeros(3))
    turn = quaternions.product(
        quaternions.bent(eps[1], eps[2]), quaternions.about(np.array([1.0, 0, 0]), eps[0])
    )
    return Hinge(parent, at, E, ca.SX.zeros(3), S, bias, body, quaternions.seen_from(triad, turn))


def _vee(skew: SX) -> SX:
    return ca.vertcat(skew[2, 1], skew[0, 2], skew[1, 0])
