"""What a robot carries: ten inertial parameters of its last link more, by two identifications.

Each is one of the whole robot, from logs without and from logs with the load, by the same estimator. What
both determine of the robot, F p, differs by F times the load at the last link, and their covariances add up:
generalised least squares gives the load. No value of the robot file is used.
"""

import warnings
from dataclasses import dataclass

import numpy as np

from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.estimation.identify import Identified
from pyident.estimation.physical import pseudo_inertia
from pyident.logs.log import LogError
from pyident.regression.machine.svd import svd

_ABSENT = 1e-6  # singular value, of the largest, below which a direction is not determined
_OPEN = 1e-3  # entry of an undetermined direction from which on a parameter takes part in it
_ROUGH = 1e-3  # [kg, m] size of a parameter that the logs do not tell
_SMALLEST = 1e-9  # eigenvalue of the pseudo-inertia [kg, m]


@dataclass(frozen=True)
class Carried:
    """The ten parameters about the last link's joint, in its axes; in the order of LINK_PARAMETERS.

    free         as the two identifications differ;  std: inf where the logs do not determine one
    consistent   the nearest that a body can have, in standard deviations
    far          how many standard deviations off
    rank         combinations of the ten that the logs determine
    none_fits    whether no load at all lies within their common 95 % region
    """

    free: np.ndarray
    std: np.ndarray
    covariance: np.ndarray
    consistent: np.ndarray
    far: float
    rank: int
    none_fits: bool


def carried(robot: Robot, empty: Identified, loaded: Identified) -> Carried:
    """What the robot carries in the logs of `loaded`, and not in those of `empty`."""
    from scipy.stats import chi2  # here: slow to import

    names, link = list(empty.reduced.columns), last_link(robot)
    scale = empty.solution.scale
    F = _determined(empty, loaded)
    C = F.T @ (_scaled(empty, scale) + _scaled(loaded, scale)) @ F
    y = F.T @ (scale * (loaded.solution.p - empty.solution.p))
    X = F[[names.index(name) for name in link]].T * scale[[names.index(name) for name in link]]
    root = np.linalg.cholesky(C + 1e-14 * np.trace(C) * np.eye(len(C)))
    A, b = np.linalg.solve(root, X), np.linalg.solve(root, y)
    size = np.linalg.norm(A, axis=0)
    unseen = size <= _ABSENT * size.max()
    size[unseen], A[:, unseen] = 1.0, 0.0
    U, s, Vt = svd(A / size, full=True)
    rank = int((s > _ABSENT * s[0]).sum())
    spread = Vt[:rank].T / s[:rank] / size[:, None]
    told = U[:, :rank].T @ b  # a standard deviation each
    p, covariance = spread @ told, spread @ spread.T
    absent = np.abs(Vt[rank:]).max(axis=0, initial=0.0) > _OPEN
    consistent, far = _nearest(p, covariance, absent)
    std = np.where(absent, np.inf, np.sqrt(np.diag(covariance)))
    none_fits = bool(told @ told < chi2.ppf(0.95, rank))
    return Carried(p, std, covariance, consistent, far, rank, none_fits)


def last_link(robot: Robot) -> list[str]:
    """Names of the parameters of the link that carries the tip."""
    return [f"link{robot.last_link}.{name}" for name in LINK_PARAMETERS]


def _determined(empty: Identified, loaded: Identified) -> np.ndarray:
    """(P, R) orthonormal: combinations of scaled parameters that both tell with an interval."""
    scale = empty.solution.scale
    untold = np.isnan(np.diag(empty.solution.covariance) + np.diag(loaded.solution.covariance))
    open_ones = [one.solution.null * (scale / one.solution.scale)[:, None] for one in (empty, loaded)]
    N = np.concatenate([*open_ones, np.eye(len(scale))[:, untold]], axis=1)
    if N.shape[1] == 0:
        return np.eye(len(scale))
    U, s, _ = svd(N / np.linalg.norm(N, axis=0), full=True)
    return U[:, int((s > _ABSENT).sum()) :]


def _scaled(one: Identified, scale: np.ndarray) -> np.ndarray:
    """(P, P) covariance of scaled parameters; 0 without an interval, where `_determined` asks nothing."""
    return np.nan_to_num(one.solution.covariance) * np.outer(scale, scale)


def _nearest(p: np.ndarray, covariance: np.ndarray, absent: np.ndarray) -> tuple[np.ndarray, float]:
    """Raises LogError when the solver finds none."""
    import cvxpy as cp

    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    size = np.where(absent, np.maximum(size, np.abs(p)) + _ROUGH, size)
    correlation = covariance / np.outer(size, size)
    values, vectors = np.linalg.eigh((correlation + correlation.T) / 2)
    telling = values > 1e-9 * values.max()
    whitened = (vectors[:, telling] / np.sqrt(values[telling])).T / size
    x = cp.Variable(len(p))
    cost = cp.norm(whitened @ (x - p)) + 1e-3 * cp.norm(vectors[:, ~telling].T @ cp.multiply(x - p, 1 / size))
    problem = cp.Problem(cp.Minimize(cost), [pseudo_inertia(x) >> _SMALLEST * np.eye(4)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # "may be inaccurate": to 1e-5 of a standard deviation
        problem.solve(solver=cp.CLARABEL)
    if x.value is None:
        raise LogError(f"no physically consistent payload was found ({problem.status})")
    return np.asarray(x.value), float(np.linalg.norm(whitened @ (x.value - p)))
