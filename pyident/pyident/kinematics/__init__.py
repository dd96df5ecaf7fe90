"""Finite elements of a mechanism: its nodes as functions of a few deformations, after Jonker (1990).

Nodes are of two kinds: a translational node has Cartesian coordinates x, a rotational node carries a
triad, given by the rotation R of the base axes; in the reference configuration every R is the identity.
Elements share nodes. Each declares deformation functions D(x): some are held at zero, some are the
degrees of freedom q, some are left free. Assembly inverts them: x = F(q), eqs (5)-(7).

Every array holds all samples at once, with the sample on the LAST axis: a vector is (3, N), a triad or
rotation (3, 3, N) with its axes as columns, a Jacobian (3, n, N). Base axes and SI units throughout.
"""
