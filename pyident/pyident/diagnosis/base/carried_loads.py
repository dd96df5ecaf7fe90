"""The loads of rigid joints, as they are where friction grows with them.

A regression without such friction bends the bodies until they explain as much of it as they can, and halves
what no torque tells: the share of a joint's inertia that is its rotor's. A law of the load that is put to
these bodies' loads explains a fraction of what it should. With it the equations are y = Φ p + μ |L p| s,
which for any one μ, and given where the load L p turns its sign, is linear: y = (Φ + μ T) p. So the bodies
are taken that belong to the best μ, if the law explains more with their loads than with those found without
it, in energy: chance adds that of a few parameters.
Where the load turns its sign is first taken from the bodies found without the law, then from the torque, most
of which it is; the better end counts. Joints are asked in the order of what the law explains there, and those
that told have it while the others are asked.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import solve
from scipy.optimize import minimize_scalar

from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, bounds, columns
from pyident.diagnosis.base.projection import (
    CANCELLED,
    Base,
    Columns,
    extended,
    gain,
    joined,
    triangles,
    wider,
)
from pyident.regression.candidate_columns import effect_columns
from pyident.regression.loads.bodies import (
    carried_loads,
    carries_friction,
    link_columns,
    link_names,
    per_load,
)
from pyident.regression.spectrum import Equations

_LAW = "load_dependent_friction"
_MOST = 2.0  # coefficient
_TRIED = 17  # coefficients, before the best is refined
_FINE = 1e-4
_ROUNDS = 12  # until the load turns its sign where it did before
_SWEEPS = 2  # over the joints: the first of them have not heard the last
_LARGEST = 3.0  # load over the torque: what a rotor asks for can hardly be as large, and opposite
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
    constants = [Candidate("offset", k) for k in own if "offset" not in robot.joints[k - 1].values]
    if constants:
        X = joined([columns(robot, c, logs, levels) for c in constants])
        logs, base = wider(logs, X), extended(base, X)
    joints = [_Joint(robot, k, logs, levels) for k in own]
    joints.sort(key=lambda joint: -joint.explained(robot, base))
    plain = np.asarray(sum(R.T @ R for R in triangles(logs)))
    told: dict[int, _Friction] = {}
    for _ in range(_SWEEPS):
        for joint in joints:
            others = [j for j in joints if j is not joint and j.k in told]
            beside = plain + sum(j.products(told[j.k]) - j.products(None) for j in others)
            rests = base
            for other in others:
                rests = extended(rests, other.columns(robot))
            robot, friction = joint.tells(robot, rests, beside, chance)
            if friction is not None:
                told[joint.k] = friction
        if len(told) < 2:
            break
    return robot


def with_bodies(robot: Robot, p: np.ndarray) -> Robot:
    """The robot with the links and rotors of p (P or more,), and its own friction."""
    values = dict(zip(robot.linear_parameters, p.tolist(), strict=False))
    rotors = {parameter_name(k, "motor_inertia", "J_m") for k, _ in robot.numbered}
    return robot.with_parameters({n: v for n, v in values.items() if n in rotors or n.startswith("link")})


def whitened(log: Equations, level: np.ndarray, row: int, terms: np.ndarray) -> np.ndarray:
    """(E, K) torques (K, N) in an equation of a log, over its level (E,)."""
    return log.band.transform(log.part.used(row, terms).T) / level[:, None]


@dataclass(frozen=True)
class _Friction:
    """Of one joint under its load. turns: per log (N,), friction per newton metre of load and coefficient."""

    coefficient: float
    turns: Sequence[np.ndarray]


class _Joint:
    """A joint's equations in all logs, and what friction under its load makes of them."""

    def __init__(self, robot: Robot, k: int, logs: Sequence[Equations], levels: Sequence[np.ndarray]):
        self.k, self._logs, self._levels = k, logs, levels
        names = list(robot.linear_parameters)
        self._links = [names.index(name) for name in link_names(robot)]
        self._torque = float(np.mean(np.concatenate([log.part.target[:, k - 1] for log in logs]) ** 2))
        self._asked = [link_columns(robot, log.part.motion, k).T for log in logs]

    def tells(
        self, robot: Robot, base: Base, plain: np.ndarray, chance: float
    ) -> tuple[Robot, _Friction | None]:
        """The robot with the bodies of this joint's friction, and that; as it is where it tells nothing.

        base    without it, with what others told;  plain: (P + 1, P + 1) products of [Φ, y] of all equations
        """
        best, most = (robot, None), self.explained(robot, base) + chance**2
        for turns in (self._turns(robot), self._torque_turns()):
            at = robot
            for _ in range(_ROUNDS):
                coefficient, p = self._bilinear(at, turns, plain).best()
                at = with_bodies(at, p)
                if self._possible(at) and (found := self.explained(at, base)) > most:
                    best, most = (at, _Friction(coefficient, turns)), found
                before, turns = turns, self._turns(at)
                if all(map(np.array_equal, before, turns)):
                    break
        return best

    def _possible(self, robot: Robot) -> bool:
        """Whether its load is of the torque's size: a huge one, of a coefficient near 0, fits other laws."""
        load = np.concatenate([carried_loads(robot, log.part.motion)[:, self.k - 1] for log in self._logs])
        return float(np.mean(load**2)) <= _LARGEST**2 * self._torque

    def products(self, friction: _Friction | None) -> np.ndarray:
        """(P + 1, P + 1) of [Φ + μ T, y], of this joint's equations."""
        found = 0.0
        for number, log in enumerate(self._logs):
            A, y = log.A[self.k - 1], log.y[self.k - 1]
            if friction is not None:
                A = A + friction.coefficient * self._load(number, friction.turns[number])
            whole = np.column_stack([A, y])
            found = found + whole.T @ whole
        return np.asarray(found)

    def columns(self, robot: Robot) -> Columns:
        """Of the law, with the loads of a robot's bodies."""
        return columns(robot, Candidate(_LAW, self.k), self._logs, self._levels)

    def explained(self, robot: Robot, base: Base) -> float:
        """Energy that the law takes of what a base leaves."""
        return gain(base, self.columns(robot), *bounds(robot, Candidate(_LAW, self.k))).energy

    def _turns(self, robot: Robot) -> list[np.ndarray]:
        """As of `_Friction`, with the sign of a robot's loads: -1, 0 or 1, or between."""
        found = []
        for log in self._logs:
            motion = log.part.motion
            friction = effect_columns(robot, self.k, _LAW, motion)["coefficient"][self.k - 1]
            found.append(per_load(friction, carried_loads(robot, motion)[:, self.k - 1]))
        return found

    def _torque_turns(self) -> list[np.ndarray]:
        """The same where the load has the sign of the torque."""
        row = self.k - 1
        return [np.sign(log.part.target[:, row] * log.part.motion.dq[:, row]) for log in self._logs]

    def _load(self, number: int, turns: np.ndarray) -> np.ndarray:
        """T (E, P) in a log."""
        log, row = self._logs[number], self.k - 1
        T = np.zeros_like(log.A[row])
        T[:, self._links] = whitened(log, self._levels[number][row], row, self._asked[number] * turns)
        return T

    def _bilinear(self, robot: Robot, turns: Sequence[np.ndarray], plain: np.ndarray) -> "_Bilinear":
        P = len(plain) - 1
        PT, TT = np.zeros((2, P, P))
        Ty, p = np.zeros((2, P))
        for number, (log, turned) in enumerate(zip(self._logs, turns, strict=True)):
            A, y, T = log.A[self.k - 1], log.y[self.k - 1], self._load(number, turned)
            PT, TT, Ty = PT + A.T @ T, TT + T.T @ T, Ty + T.T @ y
        values = list(robot.linear_parameters.values())
        p[: len(values)] = values
        return _Bilinear(plain[:-1, :-1], PT, TT, plain[:-1, -1], Ty, float(plain[-1, -1]), p)


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
        scale = np.sqrt(np.maximum(np.diag(H), 0.0))
        seen = scale > CANCELLED * scale.max()
        scale[~seen] = 1.0
        scaled = np.where(np.outer(seen, seen), H / np.outer(scale, scale), 0.0) + _KEPT * np.eye(len(H))
        p = self.p + solve(scaled, seen * (b - H @ self.p) / scale, assume_a="sym") / scale
        return float(self.yy - 2 * b @ p + p @ H @ p), p

    def best(self) -> tuple[float, np.ndarray]:
        """The coefficient that leaves least, and its p (P,)."""
        tried = np.linspace(0, _MOST, _TRIED)
        left = [self.solved(mu)[0] for mu in tried.tolist()]
        i = int(np.argmin(left))
        around = tried[max(i - 1, 0)], tried[min(i + 1, _TRIED - 1)]
        found: Any = minimize_scalar(
            lambda mu: self.solved(mu)[0], bounds=around, method="bounded", options={"xatol": _FINE}
        )
        mu = float(found.x) if found.fun < left[i] else float(tried[i])
        return mu, self.solved(mu)[1]
