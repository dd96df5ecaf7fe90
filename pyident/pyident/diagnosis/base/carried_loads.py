"""The loads of rigid joints, as they are where friction grows with them.

A regression without such friction bends the bodies until they explain as much of it as they can, and halves
what no torque tells: the share of a joint's inertia that is its rotor's. A law of the load that is put to
these bodies' loads explains a fraction of what it should. With it the equations are y = Φ p + μ |L p| s,
which for any one μ, and given where the load L p turns its sign, is linear: y = (Φ + μ T) p. So the bodies
are taken that belong to the best μ, if the law explains more with their loads than chance makes of any other.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import solve
from scipy.optimize import minimize_scalar

from flexmodels.joint import parameter_name
from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, bounds, candidates, columns
from pyident.diagnosis.base.projection import Base, Columns, extended, gain, triangles
from pyident.regression.candidate_columns import effect_columns
from pyident.regression.loads.bodies import carried_loads, carries_friction, link_columns
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
    acting = {c.joint for c in candidates(robot, logs) if c.effect == _LAW}
    own = [k for k in sorted(acting) if not robot.joints[k - 1].flexible]
    if not own or any(law.body for joint in robot.joints for law in joint.effects):
        return robot
    plain = sum(R.T @ R for R in triangles(logs))
    for k in own:
        if not carries_friction(robot.joints[k - 1]):
            robot = _told(robot, k, logs, base, levels, np.asarray(plain), chance)
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
    at, turned = robot, None
    for _ in range(_ROUNDS):
        before, turned = turned, [_turns(at, k, e) for e in logs]
        if before is not None and all(map(np.array_equal, before, turned)):
            break
        equations = _bilinear(at, k, logs, levels, turned, plain, constants)
        at = _with_bodies(at, equations.best())
        if (energy := explained(at)) > most:
            best, most = at, energy
    return best


def _turns(robot: Robot, k: int, log: Equations) -> np.ndarray:
    """(N,) friction of the law per newton metre of its load, which has its sign: -1, 0 or 1, or between."""
    motion = log.part.motion
    friction = effect_columns(robot, k, _LAW, motion)["coefficient"][k - 1]
    load = carried_loads(robot, motion)[:, k - 1]
    return np.divide(friction, load, out=np.zeros_like(load), where=load != 0)


def _with_bodies(robot: Robot, p: np.ndarray) -> Robot:
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


def _bilinear(
    robot: Robot,
    k: int,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    turned: Sequence[np.ndarray],
    plain: np.ndarray,
    constants: Columns | None,
) -> _Bilinear:
    """plain: (P + 1, P + 1) products of [Φ, y];  constants: one more column of Φ, at the joint."""
    names = list(robot.linear_parameters)
    links = [names.index(f"link{i + 1}.{n}") for i in range(len(robot.links)) for n in LINK_PARAMETERS]
    P, row = len(names), k - 1
    width = P + (constants is not None)
    PP, PT, TT = np.zeros((3, width, width))
    Py, Ty = np.zeros((2, width))
    PP[:P, :P], Py[:P] = plain[:P, :P], plain[:P, P]
    for number, (log, level, turns) in enumerate(zip(logs, levels, turned, strict=True)):
        A, T = (np.zeros((log.y.shape[1], width)) for _ in range(2))
        A[:, :P] = log.A[row]
        asked = link_columns(robot, log.part.motion, k).T * turns
        T[:, links] = log.band.transform(log.part.used(row, asked).T) / level[row][:, None]
        if constants is not None:
            A[:, P:] = constants[number][row]
            PP[:P, P:] += A[:, :P].T @ A[:, P:]
            PP[P:, P:] += A[:, P:].T @ A[:, P:]
            Py[P:] += A[:, P:].T @ log.y[row]
        PT, TT, Ty = PT + A.T @ T, TT + T.T @ T, Ty + T.T @ log.y[row]
    PP[P:, :P] = PP[:P, P:].T
    p = np.zeros(width)
    p[:P] = list(robot.linear_parameters.values())
    return _Bilinear(PP, PT, TT, Py, Ty, float(plain[P, P]), p)
