"""Forward dynamics by the mass matrix, for a robot with passive joints or with coupled motors.

The passive joints follow the coordinates, q_tree = G q with a constant G, so the tree's equations of motion
are put upon q by Gᵀ (virtual power); articulated bodies know no such tie. A few coordinates remain, whose
symmetric mass matrix is factored symbolically, M = L D Lᵀ.
"""

import casadi as ca

from flexmodels.mechanics.dynamics import SX, Mechanism, inverse_dynamics


def forward_dynamics(m: Mechanism, force: SX, armature: SX, free: SX) -> tuple[SX, SX]:
    """Accelerations under generalised forces, and the torque imbalance at each coordinate that is held.

    force, free   [n] as in `mechanics.articulated.forward_dynamics`;  armature   n x n. With F = diag(free)
    (F M F + I − F) a = F (force − h)   and the imbalance is   force − h − M a.
    """
    a, total, M = _mass_matrix(m, armature)
    net = force - ca.substitute(total, a, ca.SX.zeros(a.numel()))
    F = ca.diag(free)
    D, LT, order = ca.ldl(F @ M @ F + ca.SX.eye(a.numel()) - F)
    found = ca.ldl_solve(F @ net, D, LT, order)
    return found, net - M @ found


def pivots(m: Mechanism, armature: SX) -> SX:
    """n pivots of the mass matrix, all positive where it is definite; armature n x n."""
    _, _, M = _mass_matrix(m, armature)
    return ca.ldl(ca.densify(M))[0]


def _mass_matrix(m: Mechanism, armature: SX) -> tuple[SX, SX, SX]:
    """Symbols a [n], the forces M a + h without the motors' inertias, and M with them."""
    a = ca.SX.sym("a", m.q.numel())
    total = inverse_dynamics(m, a)
    return a, total, ca.jacobian(total, a) + armature
