"""The physically consistent parameters nearest to a least-squares solution.

Every link keeps a positive pseudo-inertia (Wensing, Kim and Slotine 2018), every stiffness, damping,
friction level and motor inertia stays non-negative; so the model's mass matrix is positive definite
whatever the data left open.
"""

import cvxpy as cp
import numpy as np
from flexmodels.effects import CATALOGUE
from flexmodels.robot import LINK_PARAMETERS, Robot, parameter_name

from pyident.solve import Reduced, Solution

_OPEN = 1e-4  # weight, against the best seen direction, that keeps undetermined directions small
_SMALLEST = 1e-6  # eigenvalue of a link's pseudo-inertia [kg, m]


def consistent(robot: Robot, reduced: Reduced, solution: Solution) -> np.ndarray:
    """Parameters (P,) that minimise |A p - y| under the physical bounds.

    Directions that the data do not determine are settled by the bounds and by small size.
    Raises RuntimeError when the solver finds no such parameters.
    """
    names, scale = list(reduced.columns), solution.scale
    A, y = reduced.stacked(solution.weights)
    R = np.linalg.qr(A / scale, mode="r")
    z = cp.Variable(len(names))
    near = solution.p * scale
    p = cp.multiply(z, 1 / scale)
    keep_small = _OPEN * solution.singular_values[0]
    misfit = cp.norm(cp.hstack([R @ (z - near), keep_small * (z - near)]))
    limits: list[cp.Constraint] = [
        _pseudo_inertia(p, names, k) >> _SMALLEST * np.eye(4) for k, _ in robot.numbered
    ]
    limits += [
        z[names.index(name)] >= bound * scale[names.index(name)]
        for name, bound in lower_bounds(robot).items()
    ]
    problem = cp.Problem(cp.Minimize(misfit / float(np.linalg.norm(y))), limits)
    problem.solve(solver=cp.CLARABEL)
    if z.value is None:
        raise RuntimeError(f"no physically consistent parameters were found ({problem.status})")
    return np.asarray(z.value) / scale


def lower_bounds(robot: Robot) -> dict[str, float]:
    """Parameter name -> least value, for the laws' parameters that have one."""
    return {
        parameter_name(k, effect, parameter.name): parameter.lower
        for k, joint in robot.numbered
        for effect in joint.values
        for parameter in CATALOGUE[effect].parameters
        if np.isfinite(parameter.lower)
    }


def _pseudo_inertia(p: cp.Expression, names: list[str], link: int) -> cp.Expression:
    m, x, y, z, xx, xy, xz, yy, yz, zz = (p[names.index(f"link{link}.{n}")] for n in LINK_PARAMETERS)
    half = (xx + yy + zz) / 2
    return cp.bmat(
        [[half - xx, -xy, -xz, x], [-xy, half - yy, -yz, y], [-xz, -yz, half - zz, z], [x, y, z, m]]
    )
