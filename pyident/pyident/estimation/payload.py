"""What a robot carries: ten inertial parameters more of its last link, from a log without and one with it.

Robot and payload are found in one regression, in which the loaded logs have the columns of the last link
twice. So no value of the robot file is used, and an error that both logs share goes to the robot.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.conditioning.windows import prepared
from pyident.estimation.estimate import estimate
from pyident.logs.disk import LogFile
from pyident.logs.log import Log
from pyident.regression.equations import Block, Part, Problem

NAMES = tuple(f"payload.{name}" for name in LINK_PARAMETERS)
_ROUGH = 1e-3  # [kg, m] size of a parameter that the logs do not tell
_SMALLEST = 1e-9  # eigenvalue of the pseudo-inertia [kg, m]


@dataclass(frozen=True)
class Carried:
    """The ten parameters about the last link's joint, in its axes; in the order of LINK_PARAMETERS.

    free         as the regression found them;  std: inf where the logs do not determine one
    consistent   the nearest that a body can have, in standard deviations
    far          how many standard deviations off
    """

    free: np.ndarray
    std: np.ndarray
    covariance: np.ndarray
    consistent: np.ndarray
    far: float


@dataclass(frozen=True)
class _Loaded(Problem):
    """The regression with the payload's columns; `empty`: how many parts come without it."""

    empty: int = 0

    @property
    def columns(self) -> tuple[str, ...]:
        return (*super().columns, *NAMES)

    def _blocks(self, part: Part, weights: np.ndarray | None) -> Iterator[Block]:
        own = tuple(self.robot.linear_parameters)
        at = [own.index(name) for name in last_link(self.robot)]
        loaded = any(part is one for one in self.parts[self.empty :])
        for A, y in super()._blocks(part, weights):
            added = A[:, :, at] if loaded else np.zeros((*A.shape[:2], len(at)))
            yield np.concatenate([A, added], axis=2), y


def carried(robot: Robot, empty: Sequence[Log | LogFile], loaded: Sequence[Log | LogFile]) -> Carried:
    """What the loaded logs carry more than the empty ones. Raises LogError."""
    parts = tuple(prepared(log, robot) for log in (*empty, *loaded))
    _, solution = estimate(_Loaded(robot, parts, len(empty)))
    n = len(NAMES)
    covariance = solution.covariance[-n:, -n:]
    consistent, far = _nearest(solution.p[-n:], covariance, solution.open[-n:])
    return Carried(solution.p[-n:], solution.std[-n:], covariance, consistent, far)


def last_link(robot: Robot) -> list[str]:
    """Names of the parameters of the link that carries the tip."""
    return [f"link{robot.last_link}.{name}" for name in LINK_PARAMETERS]


def _nearest(p: np.ndarray, covariance: np.ndarray, absent: np.ndarray) -> tuple[np.ndarray, float]:
    """Raises RuntimeError when the solver finds none."""
    import cvxpy as cp

    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    size = np.where(absent, np.maximum(size, np.abs(p)) + _ROUGH, size)
    correlation = covariance / np.outer(size, size)
    values, vectors = np.linalg.eigh((correlation + correlation.T) / 2)
    telling = values > 1e-9 * values.max()
    whitened = (vectors[:, telling] / np.sqrt(values[telling])).T / size
    x = cp.Variable(len(p))
    m, a, b, c, xx, xy, xz, yy, yz, zz = (x[i] for i in range(len(p)))
    half = (xx + yy + zz) / 2
    body = cp.bmat(
        [[half - xx, -xy, -xz, a], [-xy, half - yy, -yz, b], [-xz, -yz, half - zz, c], [a, b, c, m]]
    )
    cost = cp.norm(whitened @ (x - p)) + 1e-3 * cp.norm(vectors[:, ~telling].T @ cp.multiply(x - p, 1 / size))
    problem = cp.Problem(cp.Minimize(cost), [body >> _SMALLEST * np.eye(4)])
    problem.solve(solver=cp.CLARABEL)
    if x.value is None:
        raise RuntimeError(f"no physically consistent payload was found ({problem.status})")
    return np.asarray(x.value), float(np.linalg.norm(whitened @ (x.value - p)))
