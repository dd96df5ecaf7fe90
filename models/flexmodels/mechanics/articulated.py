"""Articulated bodies of a tree in CasADi: forward dynamics, and the pivots of the mass matrix.

Featherstone, Rigid Body Dynamics Algorithms, 2008, ABA table 7.1, in the frames of mechanics.dynamics.
"""

from dataclasses import dataclass

import casadi as ca

from flexmodels.mechanics.dynamics import (
    SX,
    Mechanism,
    base_acceleration,
    motion_transform,
    motions,
    wrench,
)


@dataclass(frozen=True)
class Articulated:
    """A hinge with all that it carries: U = IA S, D = Sᵀ U + armature, its inverse where the hinge is free.

    Ia   6 x 6 inertia that the hinge's parent feels
    """

    U: SX
    D: SX
    gain: SX
    Ia: SX


def forward_dynamics(m: Mechanism, force: SX, armature: SX, free: SX) -> tuple[SX, SX]:
    """Accelerations of a tree without passive joints under generalised forces, and the torque imbalance.

    force, armature, free   [n]; free = 0 holds a (motor) coordinate at constant speed, 1 lets it move.
    The imbalance at a held coordinate is the torque that a brake must take there.
    """
    moving, bodies = motions(m), _articulated(m, armature, free)
    bias_force = [
        wrench(h, velocity, ca.SX.zeros(6)) for h, (_, velocity, _) in zip(m.hinges, moving, strict=True)
    ]
    net_force: list[SX] = [None] * len(m.hinges)
    for i in reversed(range(len(m.hinges))):
        hinge, (X, _, c), body = m.hinges[i], moving[i], bodies[i]
        net_force[i] = force[hinge.coordinates] - hinge.S.T @ bias_force[i]
        if hinge.parent is not None:
            pa = bias_force[i] + body.Ia @ c + body.U @ body.gain @ net_force[i]
            bias_force[hinge.parent] = bias_force[hinge.parent] + X.T @ pa
    accelerations = []
    qdd, imbalance = ca.SX.zeros(m.q.numel()), ca.SX.zeros(m.q.numel())
    for hinge, (X, _, c), body, u in zip(m.hinges, moving, bodies, net_force, strict=True):
        before = base_acceleration(m) if hinge.parent is None else accelerations[hinge.parent]
        acceleration = X @ before + c
        net = u - body.U.T @ acceleration
        qdd[hinge.coordinates] = body.gain @ net
        imbalance[hinge.coordinates] = net
        accelerations.append(acceleration + hinge.S @ qdd[hinge.coordinates])
    return qdd, imbalance


def pivots(m: Mechanism, armature: SX) -> SX:
    """n pivots of the mass matrix of a tree without passive joints: all positive where it is definite.

    The elimination from the tips to the base is that of the articulated bodies; armature [n].
    """
    bodies = _articulated(m, armature, ca.SX.ones(m.q.numel()))
    return ca.vertcat(*(ca.ldl(ca.densify(body.D), False)[0] for body in bodies))


def _articulated(m: Mechanism, armature: SX, free: SX) -> list[Articulated]:
    inertia = [ca.SX.zeros(6, 6) if h.inertia is None else h.inertia for h in m.hinges]
    bodies: list[Articulated] = []
    for i in reversed(range(len(m.hinges))):
        hinge = m.hinges[i]
        IA, S, at, X = inertia[i], hinge.S, hinge.coordinates, motion_transform(hinge)
        U = IA @ S
        D = S.T @ U + ca.diag(armature[at])
        gain = _inverse(D) * (free[at] if len(at) == 1 else 1)
        bodies.insert(0, Articulated(U, D, gain, _symmetric(IA - U @ gain @ U.T)))
        if hinge.parent is not None:
            inertia[hinge.parent] = _symmetric(inertia[hinge.parent] + X.T @ bodies[0].Ia @ X)
    return bodies


def _inverse(D: SX) -> SX:
    return 1 / D if D.numel() == 1 else _symmetric(ca.inv_minor(D))


def _symmetric(A: SX) -> SX:
    """A symmetric matrix by its upper half alone: the lower half's operations are never generated."""
    return ca.triu2symm(ca.triu(A))
