"""What links ask of rigid joints, where friction depends on it: a law that is implicit in the accelerations.

Behind a motor that turns its link directly the transmission carries what the links need to move so,
load = M(q) q̈ + h(q, q̇), without the motor's own inertia. The accelerations fall with the friction, and the
friction with the accelerations. Every load is affine in the forces, so that a few of Newton's steps, in as
many unknowns as there are such joints, solve for all: exactly for |load|, by which a step changes its mind
only where a sign does.
"""

from collections.abc import Callable, Sequence

import casadi as ca

from flexmodels.mechanics.dynamics import SX

_ROUNDS = 5  # a friction of load² at a third of the load itself needs them

ForwardDynamics = Callable[[SX], tuple[SX, SX]]  # generalised forces [n] -> accelerations, imbalance [n]


def settled(
    load: SX, places: Sequence[int], applied: SX, free: SX, armature: SX, forward: ForwardDynamics
) -> SX:
    """The loads [m] under which the forces that depend on them leave just these loads.

    load, places   [m], their symbols in `applied`, and the coordinates that carry them
    applied        [n], generalised forces: the motors' less the laws'
    free           [n], 0 where a coordinate is held
    armature       n x n, inertia that is not the links'
    """
    force = ca.SX.sym("force", applied.numel())
    accelerations, imbalance = forward(force)
    carried = (force - armature @ accelerations - (1 - free) * imbalance)[list(places)]
    slope = ca.jacobian(carried, force)
    without = ca.substitute(applied, load, ca.SX.zeros(load.numel()))
    freely = ca.substitute(carried, force, without)
    missed = load - freely - slope @ (applied - without)
    tangent = ca.SX.eye(load.numel()) - slope @ ca.jacobian(applied, load)
    at = freely
    for _ in range(_ROUNDS):
        here = ca.substitute([tangent, missed], [load], [at])
        at = ca.cse(at - ca.solve(*here))
    return at
