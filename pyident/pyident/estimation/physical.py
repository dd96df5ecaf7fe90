"""The physically consistent parameters nearest to a least-squares solution.

Every link keeps a positive pseudo-inertia (Wensing, Kim and Slotine 2018), every stiffness, damping,
friction level and motor inertia stays non-negative; so the model's mass matrix is positive definite
whatever the data left open. Where a prior is given, directions that the data leave open stay near it: bodies
in the Bregman distance of the log-determinant, which is that of mass distributions whatever the units (Lee,
Wensing and Park 2020), what belongs to a joint in shares of its prior value, unless data tell it alone.
"""

import threading
import warnings
from collections.abc import Container, Mapping
from typing import TYPE_CHECKING

import numpy as np

from flexmodels.joint import parameter_name
from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.estimation.least_squares import Solution
from pyident.logs.log import LogError
from pyident.regression.reduced import Reduced, unit_of

if TYPE_CHECKING:
    import cvxpy as cp

_OPEN = 1e-3  # standard deviations that undetermined directions may cost, per length of the parameters
_TRUSTED = 0.5  # of a prior's values: standard deviation that is conceded to them
_ALONE = 1e-6  # share of a parameter in what the data leave open: less is rounding
_EXTENT = 0.01  # m: least radius of gyration of a prior's body
_EXACT = 1e-9  # of the parameters' length: the least standard deviation
_NONE = "no physically consistent parameters were found"
_CURE = "`pyident log inspect` shows what the log's channels hold: look for a wrong unit or sign"
_warnings_held = threading.Lock()  # filters of warnings are those of all threads
_SMALLEST = 1e-6  # eigenvalue of a link's pseudo-inertia [kg, m]


def consistent(
    robot: Robot,
    reduced: Reduced,
    solution: Solution,
    prior: Robot | None = None,
    within: float | None = None,
    known: Mapping[str, float] | None = None,
) -> np.ndarray:
    """Parameters (P,) under the physical bounds, as few standard deviations from the solution as possible.

    Directions that the data do not determine are settled by the bounds and by nearness to the prior, or where
    there is none by small size.

    within   factor of the prior's masses in which those of the links are held; None: they are free
    known    parameters that have just these values; None: none has
    Raises LogError when the solver finds no such parameters.
    """
    import cvxpy as cp

    bounds, masses = lower_bounds(robot), {} if within is None or prior is None else _masses(prior, within)
    names, units = list(reduced.columns), _units(robot, reduced, solution)
    x = cp.Variable(len(names))
    p = cp.multiply(x, units)
    limits: list[cp.Constraint] = [
        _body(x, names, k + 1) >> _SMALLEST * np.eye(4) for k in range(len(robot.links))
    ]
    for name, least in bounds.items():
        limits.append(x[names.index(name)] >= least / units[names.index(name)])
    for name, value in (known or {}).items():
        limits.append(x[names.index(name)] == value / units[names.index(name)])
    for name, (least, most) in masses.items():
        limits += [p[names.index(name)] >= least, p[names.index(name)] <= most]
    u, t = cp.Variable(solution.rank), cp.Variable(solution.null.shape[1])
    limits += _away(reduced, solution, prior, x, units, u, t)
    if prior is None:
        cost = cp.norm(u) + _OPEN * cp.norm(t)
    else:
        shared = {
            name
            for name, row in zip(names, solution.null, strict=True)
            if np.abs(row).max(initial=0) > _ALONE
        }
        cost = cp.sum_squares(u) / 2 + _distance(p, names, prior, shared) / _TRUSTED**2
    problem = cp.Problem(cp.Minimize(cost), limits)
    try:
        with _warnings_held, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # "may be inaccurate": to 1e-5 of a deviation
            problem.solve(solver=cp.CLARABEL)
    except cp.SolverError:
        raise LogError(f"{_NONE}: the solver gave up; {_CURE}") from None
    if p.value is None:
        raise LogError(f"{_NONE}: the problem is {problem.status}; {_CURE}")
    found = np.maximum(np.asarray(p.value), [bounds.get(name, -np.inf) for name in names])
    return _without_rounding(found, names, len(robot.links))


def _without_rounding(p: np.ndarray, names: list[str], links: int) -> np.ndarray:
    """p (P,) with bodies as large as they must be to exist, which a solver keeps to its tolerance alone."""
    p = p.copy()
    for k in range(1, links + 1):
        at = {name: names.index(f"link{k}.{name}") for name in LINK_PARAMETERS}
        least = np.linalg.eigvalsh(_pseudo_inertia(p[list(at.values())]))[0]
        if least < 0:
            p[at["m"]] -= least
            p[[at["J[xx]"], at["J[yy]"], at["J[zz]"]]] -= 2 * least
    return p


def _units(robot: Robot, reduced: Reduced, solution: Solution) -> np.ndarray:
    """(P,) in which values are of one size to the solver: bodies in kilograms and the robot's lengths.

    What belongs to a joint is measured by its column, as bodies are on average.
    """
    lengths = [np.linalg.norm(joint.origin) for joint in robot.joints] + [np.linalg.norm(robot.tip)]
    length = float(max(lengths)) or 1.0
    own = {"m": 1.0, "ms": length, "J": length**2}
    acting = np.where(solution.seen.any(axis=1), solution.scale, np.nan)
    units = np.array([own[unit_of(name)] if name.startswith("link") else np.nan for name in reduced.columns])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # nothing acts
        usual = np.exp(np.nanmean(np.log(units * acting)))
    of_joints = np.where(np.isfinite(usual / acting), usual / acting, 1.0)
    return np.where(np.isfinite(units), units, of_joints)


def _away(
    reduced: Reduced,
    solution: Solution,
    prior: Robot | None,
    x: "cp.Variable",
    units: np.ndarray,
    u: "cp.Variable",
    t: "cp.Variable",
) -> list["cp.Constraint"]:
    """u, in standard deviations from the solution where the data determine it, and t, the rest of its length.

    Variables of their own, tied to x: of exact data a deviation is so short that the solver cannot count with
    an expression of x, or of them, alone.
    """
    length = max(float(np.linalg.norm(solution.p * solution.scale)), 1e-300)
    scale = solution.scale / length
    told = solution.seen.T @ (scale * solution.p)
    deviations = _deviations(reduced, solution, prior) / length
    return [
        (solution.seen.T * scale * units) @ x - told == deviations @ u,
        (solution.null.T * scale * units) @ x - solution.null.T @ (scale * solution.p) == t,
    ]


def _masses(prior: Robot, within: float) -> dict[str, tuple[float, float]]:
    known = {f"link{k}.m": link.m for k, link in enumerate(prior.links, start=1) if link.m > 0}
    return {name: (m / within, m * within) for name, m in known.items()}


def misfit(reduced: Reduced, solution: Solution, p: np.ndarray, prior: Robot) -> float:
    """Mean square distance of p (P,) from a solution in standard deviations, where the data determine it."""
    D = _deviations(reduced, solution, prior)
    u = np.linalg.solve(D, solution.seen.T @ ((p - solution.p) * solution.scale))
    return float(u @ u / max(solution.rank, 1))


def _distance(p: "cp.Expression", names: list[str], prior: Robot, shared: Container[str]) -> "cp.Expression":
    """Convex distance of parameters to a prior's: half the summed squares of small relative changes.

    shared   names of those that data tell together with others, if at all: of a joint's parameters the prior
             holds these alone, as a friction in a robot file may be a placeholder that is far too small
    """
    import cvxpy as cp

    known, terms = prior.parameters, []
    for k, link in enumerate(prior.links, start=1):
        if link.m <= 0:
            continue
        L = np.linalg.inv(np.linalg.cholesky(_prior_body(known, k)))
        body = L @ _body(p, names, k) @ L.T
        terms.append(cp.trace(body) - cp.log_det(body) - 4)
    positive = {name for name, bound in lower_bounds(prior).items() if bound == 0}
    of_joints = [
        i
        for i, name in enumerate(names)
        if not name.startswith("link") and known.get(name) and name in shared
    ]
    for bounded in (True, False):
        at = [i for i in of_joints if (names[i] in positive) == bounded]
        if at:
            ratio = cp.multiply(p[at], 1 / np.array([known[names[i]] for i in at]))
            terms.append(cp.sum(ratio - cp.log(ratio) - 1) if bounded else cp.sum_squares(ratio - 1) / 2)
    return sum(terms, cp.Constant(0.0))


def _prior_body(known: Mapping[str, float], link: int) -> np.ndarray:
    """(4, 4) a prior's pseudo-inertia; a body without extent gets the least one."""
    m, x, y, z, xx, xy, xz, yy, yz, zz = (known[f"link{link}.{name}"] for name in LINK_PARAMETERS)
    rotational = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    first = np.array([x, y, z])
    central = np.trace(rotational) / 2 * np.eye(3) - rotational - np.outer(first, first) / m
    size, axes = np.linalg.eigh(central)
    central = axes * np.maximum(size, m * _EXTENT**2) @ axes.T
    body = np.zeros((4, 4))
    body[:3, :3] = central + np.outer(first, first) / m
    body[:3, 3] = body[3, :3] = first
    body[3, 3] = m
    return body


def _deviations(reduced: Reduced, solution: Solution, prior: Robot | None) -> np.ndarray:
    """(r, r) whose columns, along the directions that the data determine, are one standard deviation each.

    Beside a prior those of the covariance, where there is one: residuals with a memory tell less than as
    many white ones, which would give every right to the data. Else those of white residuals.
    """
    s = solution.singular_values[: solution.rank]
    least = _EXACT * float(np.linalg.norm(solution.p * solution.scale)) / s
    turn = solution.seen * solution.scale[:, None]
    known = turn.T @ solution.covariance @ turn
    if prior is None or not np.isfinite(known).all():
        return np.diag(np.maximum(_sigma(reduced, solution) / s, least))
    variance, axes = np.linalg.eigh((known + known.T) / 2 + np.diag(least**2))
    return axes * np.sqrt(np.maximum(variance, least.min() ** 2))


def _sigma(reduced: Reduced, solution: Solution) -> float:
    """Standard deviation of one weighted equation."""
    squares = (solution.weights * solution.residual) ** 2 * reduced.samples
    return float(np.sqrt(squares.sum() / max(reduced.samples * len(reduced.rows) - solution.rank, 1)))


def lower_bounds(robot: Robot) -> dict[str, float]:
    """Parameter name -> least value, for the laws' parameters that have one."""
    return {
        parameter_name(k, effect, parameter.name): parameter.lower
        for k, joint in robot.numbered
        for effect, values in joint.values.items()
        for parameter in joint.catalogue[effect].linear
        if parameter.name in values and np.isfinite(parameter.lower)
    }


def _body(p: "cp.Expression", names: list[str], link: int) -> "cp.Expression":
    return pseudo_inertia(p[[names.index(f"link{link}.{name}") for name in LINK_PARAMETERS]])


def pseudo_inertia(body: "cp.Expression") -> "cp.Expression":
    """(4, 4) of ten values in the order of LINK_PARAMETERS; positive definite for what can be a body."""
    import cvxpy as cp

    each = [_pseudo_inertia(np.eye(10)[i]).ravel() for i in range(10)]
    return cp.reshape(np.column_stack(each) @ body, (4, 4), order="C")


def _pseudo_inertia(body: np.ndarray) -> np.ndarray:
    """(4, 4) of ten numbers."""
    m, x, y, z, xx, xy, xz, yy, yz, zz = body
    half = (xx + yy + zz) / 2
    return np.array(
        [[half - xx, -xy, -xz, x], [-xy, half - yy, -yz, y], [-xz, -yz, half - zz, z], [x, y, z, m]]
    )
