"""The loads of rigid joints, as they are where friction grows with them.

A regression without such friction bends the bodies until they explain as much of it as they can, and halves
what no torque tells: the share of a joint's inertia that is its rotor's. A law of the load that is put to
these bodies' loads explains a fraction of what it should. With it the equations are y = Φ p + μ |L p| s,
which for any one μ, and given where the load L p turns its sign, is linear: y = (Φ + μ T) p. So the bodies
are taken that belong to the best μ, if the law explains more with their loads than chance makes of any other.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import solve
from scipy.optimize import minimize_scalar

from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, bounds, columns
from pyident.diagnosis.base.projection import Base, Columns, extended, gain, triangles
from pyident.regression.candidate_columns import effect_columns
from pyident.regression.loads.bodies import carried_loads, carries_friction, link_columns, link_names
from pyident.regression.spectrum import Equations

_LAW = "load_dependent_friction"
_MOST = 2.0  # coefficient
_TRIED = 17  # coefficients, before the best is refined
_FINE = 1e-4
_ROUNDS = 12  # until the load turns its sign where it did before
_KEPT = 1e-9  # of a parameter's own weight: what equations leave open stays as it was


def with_carried_loads(
    robot: Robot, logs: Sequence[Equations], base: Base, levels: Sequence[np.ndarray], chance: float
) -> Robot:
    """The fitted robot with the bodies that its friction tells; base: of the logs;  levels: per log (n, E).

    chance   standard deviations by which a gain differs by chance
    """
    own = [k for k, joint in robot.numbered if not joint.flexible and not carries_friction(joint)]
    if not own or any(law.body for joint in robot.joints for law in joint.effects):
        return robot
    plain = np.asarray(sum(R.T @ R for R in triangles(logs)))
    for k in own:
        robot = _told(robot, k, logs, base, levels, plain, chance)
    return robot


def _told(
    robot: Robot,
    k: int,
    logs: Sequence[Equations],
    base: Base,
    levels: Sequence[np.ndarray],
    plain: np.ndarray,
    chance: float,
) -> Robot:
    law, constant = (Candidate(name, k) for name in (_LAW, "offset"))
    constants = None
    if constant.effect not in robot.joints[k - 1].values:
        constants = columns(robot, constant, logs, levels)
        base = extended(base, constants)

    def explained(carrying: Robot) -> float:
        return float(np.sqrt(gain(base, columns(carrying, law, logs, levels), *bounds(robot, law)).energy))

    best, most = robot, explained(robot) + chance
    own = _own_equations(robot, k, logs, levels, constants)
    plain = _with_constant(plain, own)
    at, turned = robot, None
    for _ in range(_ROUNDS):
        before, turned = turned, [_turns(at, k, e) for e in logs]
        if before is not None and all(map(np.array_equal, before, turned)):
            break
        at = with_bodies(at, _bilinear(at, own, turned, plain).best())
        if (energy := explained(at)) > most:
            best, most = at, energy
    return best


def _turns(robot: Robot, k: int, log: Equations) -> np.ndarray:
    """(N,) friction of the law per newton metre of its load, which has its sign: -1, 0 or 1, or between."""
    motion = log.part.motion
    friction = effect_columns(robot, k, _LAW, motion)["coefficient"][k - 1]
    load = carried_loads(robot, motion)[:, k - 1]
    return np.divide(friction, load, out=np.zeros_like(load), where=load != 0)


def with_bodies(robot: Robot, p: np.ndarray) -> Robot:
    """The robot with the links and rotors of p (P or more,), and its own friction."""
    values = dict(zip(robot.linear_parameters, p.tolist(), strict=False))
    rotors = {parameter_name(k, "motor_inertia", "J_m") for k, _ in robot.numbered}
    return robot.with_parameters({n: v for n, v in values.items() if n in rotors or n.startswith("link")})


@dataclass(frozen=True)
class _Bilinear:
    """Least squares of y = (Φ + μ T) p: products of Φ, T and y, summed over all equations.

    PP, PT, TT   (P, P);  Py, Ty (P,);  yy
    p            (P,) of the robot; what no equation tells stays there
    """

    PP: np.ndarray
    PT: np.ndarray
    TT: np.ndarray
    Py: np.ndarray
    Ty: np.ndarray
    yy: float
    p: np.ndarray

    def solved(self, coefficient: float) -> tuple[float, np.ndarray]:
        """Energy left, and p (P,), for one coefficient."""
        mu = coefficient
        H = self.PP + mu * (self.PT + self.PT.T) + mu**2 * self.TT
        b = self.Py + mu * self.Ty
        scale = np.sqrt(np.diag(H))
        scale[scale == 0] = 1.0
        scaled = H / np.outer(scale, scale) + _KEPT * np.eye(len(H))
        p = self.p + solve(scaled, (b - H @ self.p) / scale, assume_a="sym") / scale
        return float(self.yy - 2 * b @ p + p @ H @ p), p

    def best(self) -> np.ndarray:
        """(P,) of the coefficient that leaves least."""
        tried = np.linspace(0, _MOST, _TRIED)
        left = [self.solved(mu)[0] for mu in tried.tolist()]
        i = int(np.argmin(left))
        around = tried[max(i - 1, 0)], tried[min(i + 1, _TRIED - 1)]
        found: Any = minimize_scalar(
            lambda mu: self.solved(mu)[0], bounds=around, method="bounded", options={"xatol": _FINE}
        )
        return self.solved(float(found.x) if found.fun < left[i] else float(tried[i]))[1]


@dataclass(frozen=True)
class _Own:
    """A joint's equations in one log: A (E, P) and y (E,) of them, whitened; and what links ask of it.

    asked   (10 links, N) by `link_columns`;  whiten: (K, N) -> (E, K)
    """

    A: np.ndarray
    y: np.ndarray
    asked: np.ndarray
    whiten: Callable[[np.ndarray], np.ndarray]


def _own_equations(
    robot: Robot,
    k: int,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    constants: Columns | None,
) -> list[_Own]:
    """constants: one more column of Φ."""
    found = []
    for number, (log, level) in enumerate(zip(logs, levels, strict=True)):
        A = log.A[k - 1] if constants is None else np.hstack([log.A[k - 1], constants[number][k - 1]])
        asked = link_columns(robot, log.part.motion, k).T
        found.append(_Own(A, log.y[k - 1], asked, partial(whitened, log, level[k - 1], k - 1)))
    return found


def whitened(log: Equations, level: np.ndarray, row: int, terms: np.ndarray) -> np.ndarray:
    return log.band.transform(log.part.used(row, terms).T) / level[:, None]


def _with_constant(plain: np.ndarray, own: Sequence[_Own]) -> np.ndarray:
    """Products of [Φ, y], with those of the column of Φ that only the joint's equations may have."""
    width, P = own[0].A.shape[1], len(plain) - 1
    if width == P:
        return plain
    out = np.zeros((width + 1, width + 1))
    kept = [*range(P), width]
    out[np.ix_(kept, kept)] = plain
    out[P] = out[:, P] = sum(e.A[:, P] @ np.column_stack([e.A, e.y]) for e in own)
    return out


def _bilinear(
    robot: Robot, own: Sequence[_Own], turned: Sequence[np.ndarray], plain: np.ndarray
) -> _Bilinear:
    """plain: (P + 1, P + 1) products of [Φ, y];  turned: per log, as of `_turns`."""
    names, width = list(robot.linear_parameters), len(plain) - 1
    links = [names.index(name) for name in link_names(robot)]
    PT, TT = np.zeros((2, width, width))
    Ty, p = np.zeros((2, width))
    for e, turns in zip(own, turned, strict=True):
        T = np.zeros_like(e.A)
        T[:, links] = e.whiten(e.asked * turns)
        PT, TT, Ty = PT + e.A.T @ T, TT + T.T @ T, Ty + T.T @ e.y
    p[: len(names)] = list(robot.linear_parameters.values())
    return _Bilinear(plain[:-1, :-1], PT, TT, plain[:-1, -1], Ty, float(plain[-1, -1]), p)
