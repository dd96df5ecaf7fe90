"""Friction that would feed energy in, inertia or stiffness below zero: a channel has the wrong sign.

A hose or a spring at a joint acts against its inertia, fully where a motion has one frequency, and what a
model without it leaves may look like friction that drives. So neither speaks for a wrong sign unless it would
be negative beside a hose, too; and a torque whose friction brakes much has the right one, whatever inertia it
seems to have: a hose with a hysteresis, or another motor on the same shaft, may have the most part of it. A
wrong sign turns inertia round as well as friction. Reversed rows turn friction round alone, but that of every
joint: where another joint's brakes, what seems to drive here is a law that the model lacks, as a load that
sloshes, or a tool that spins. It is one, too, where no joint but these drives, and all torques together leave
more once theirs are turned, with or without any other one: a body shows at several joints.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmodels.coordinate import motor_of, torque_of
from flexmodels.joint import parameter_name
from pyident.checks.balances import Balances, solved
from pyident.checks.better_channels import misfit
from pyident.checks.defect import Defect
from pyident.conditioning.motion import Motion
from pyident.regression.regressor import regressor
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.log_checks import LOG_CHECKS

_BRAKES = 1 / 3  # of the exchanged power: friction that takes more tells the sign
_DRIVEN = "friction would feed energy in"
_WORSE = 1.1  # times what is left: a sign that is wrong leaves less once it is turned
_POSES = 6  # of the log at which a coordinate's inertia is looked at


def signs(of: Balances, source: str) -> Iterator[Defect]:
    """One defect per joint whose torque acts against its motion."""
    for k, reason in against(of).items():
        yield Defect(
            "gross",
            "sign",
            torque_of(k + 1),
            f"{source}: {torque_of(k + 1)} has the wrong sign against {motor_of(k + 1)}: {reason}; give "
            "one of the two columns the sign -1 in the mapping, or check the order of the rows, and that no "
            "hand and nothing else moves the robot",
        )


def against(of: Balances) -> dict[int, str]:
    """Joints (from 0) whose torque must have the other sign, and why."""
    reasons = {k: reason for k in of.joints if (reason := _reason(_Joint(of, k))) is not None}
    forwards = _DRIVEN not in reasons.values() or _any_does_not_drive(of, list(reasons))
    return {} if reasons and forwards and _turned_is_worse(of, list(reasons)) else reasons


def _turned_is_worse(of: Balances, seeming: Sequence[int]) -> bool:
    """Whether all torques leave clearly more once those that seem turned are, and no less with any other
    joint's: of two that are turned, one may be all that seems so.
    """
    left = _left(of, [])
    if _left(of, seeming) <= _WORSE * left:
        return False
    return all(_left(of, [*seeming, k]) > left for k in of.joints if k not in seeming)


def _reason(joint: "_Joint") -> str | None:
    if joint.negative(joint.rubbing, joint.least_power):
        return None if _goes_forwards(joint) else _DRIVEN
    if joint.alone.negative(-joint.rubbing, _BRAKES * joint.power):
        return None
    return "its inertia would be negative" if joint.negative(joint.turning, joint.least_inertia) else None


def _left(of: Balances, turned: Sequence[int]) -> float:
    """Share of all torques that one set of parameters leaves, those `turned` negative."""
    signs = np.ones(of.torque.shape[1])
    signs[list(turned)] = -1.0
    return misfit(of, np.diag(signs)).share


def _goes_forwards(joint: "_Joint") -> bool:
    """Whether inertia has the right sign here, as where rows are reversed, and friction another joint's."""
    if not joint.negative(-joint.turning, joint.least_inertia):
        return False
    return _any_brakes(joint.of, [joint.k])


def _any_does_not_drive(of: Balances, but: Sequence[int]) -> bool:
    """Whether the friction of a joint surely does not, but for some (from 0): in reversed rows all drive."""
    others = (_Joint(of, k) for k in of.joints if k not in but)
    return any(other.alone.above(other.rubbing, -other.least_power) for other in others)


def _any_brakes(of: Balances, but: Sequence[int]) -> bool:
    """Whether the friction of a joint does, but for some (from 0)."""
    others = (_Joint(of, k) for k in of.joints if k not in but)
    return any(other.negative(-other.rubbing, other.least_power) for other in others)


@dataclass(frozen=True)
class _Joint:
    """The equation of joint k (from 0), alone and beside a hose."""

    of: Balances
    k: int

    @cached_property
    def used(self) -> np.ndarray:
        """(N,) samples."""
        return self.of.samples.use[:, self.k] > 0

    @cached_property
    def torque(self) -> np.ndarray:
        """(M,)."""
        return self.of.torque[self.used, self.k]

    @cached_property
    def speed(self) -> np.ndarray:
        """(M,)."""
        return self.of.samples.dq[self.used, self.k]

    @cached_property
    def alone(self) -> "_Solution":
        return _solution(self.of.Phi[self.used, self.k], self.torque)

    @cached_property
    def beside_hose(self) -> "_Solution":
        hose = np.column_stack([self.of.hose(self.k), np.ones(len(self.used))])
        return _solution(self.of.beside(self.k, hose), self.torque)

    @cached_property
    def power(self) -> float:
        return float(np.mean(np.abs(self.torque * self.speed)))

    @property
    def least_power(self) -> float:
        return LOG_CHECKS.friction_share * self.power

    @property
    def least_inertia(self) -> float:
        acceleration = np.sqrt(np.mean(self.of.samples.ddq[self.used, self.k] ** 2))
        torque = np.sqrt(np.mean(np.square(self.torque)))
        return LOG_CHECKS.friction_share * float(torque / max(acceleration, 1e-300))

    @cached_property
    def rubbing(self) -> np.ndarray:
        """(P,) mean power that its friction takes, per unit of p."""
        return _friction(self.of, self.k, self.speed)

    @cached_property
    def turning(self) -> np.ndarray:
        """(P,) its inertia, per unit of p."""
        return inertia(self.of, self.k)

    def negative(self, row: np.ndarray, least: float) -> bool:
        """Whether row p (P,) is below zero by a least amount, and beside a hose, too."""
        if not self.alone.negative(row, least):
            return False
        return self.beside_hose.negative(np.pad(row, (0, len(self.beside_hose.p) - len(row))), least)


@dataclass(frozen=True)
class _Solution:
    """p (P,) of A p = y, with AᵀA and its inverse (P, P), and the variance of what is left."""

    p: np.ndarray
    normal: np.ndarray
    inverse: np.ndarray
    variance: float

    def negative(self, row: np.ndarray, least: float) -> bool:
        """Whether row p is below zero beyond chance and by a least amount; row (P,)."""
        if not self.tells(row):
            return False
        value, std = self._known(row)
        return value < -LOG_CHECKS.sure * std and value < -least

    def above(self, row: np.ndarray, least: float) -> bool:
        """Whether row p is above a value beyond chance; row (P,)."""
        if not self.tells(row):
            return False
        value, std = self._known(row)
        return value - LOG_CHECKS.sure * std > least

    def tells(self, row: np.ndarray) -> bool:
        """Whether row p is told at all; row (P,)."""
        return bool(row.any()) and _estimable(self.normal, self.inverse, row)

    def _known(self, row: np.ndarray) -> tuple[float, float]:
        """row p and its standard deviation."""
        std = EQUATIONS.coloured * float(np.sqrt(max(row @ self.inverse @ row, 0.0) * self.variance))
        return float(row @ self.p), std


def _solution(A: np.ndarray, y: np.ndarray) -> _Solution:
    """Of A (M, P), y (M,)."""
    normal, b, yy = A.T @ A, A.T @ y, float(y @ y)
    p, inverse = solved(normal, b[:, None])
    left = max(yy - float(b @ p[:, 0]), 1e-12 * yy)
    return _Solution(p[:, 0], normal, inverse, left / max(len(y) - len(p) / 2, 1))


def _estimable(normal: np.ndarray, inverse: np.ndarray, row: np.ndarray) -> bool:
    scale = np.sqrt(np.diag(normal))
    inside = np.where(scale > 0, row / np.where(scale > 0, scale, 1.0), 0.0)
    back = (normal @ (inverse @ row)) / np.where(scale > 0, scale, 1.0)
    absent = bool((row[scale == 0] != 0).any())
    off, size = float(np.linalg.norm(back - inside)), float(np.linalg.norm(inside))
    return not absent and off <= EQUATIONS.estimable * size


def _friction(of: Balances, k: int, de: np.ndarray) -> np.ndarray:
    """(P,) mean power that dry and viscous friction of joint k take, per unit."""
    row = np.zeros(len(of.columns))
    for effect, power in (("coulomb", np.abs(de)), ("viscous", de**2)):
        name = parameter_name(k + 1, effect, effect)
        if name in of.columns:
            row[of.columns.index(name)] = np.mean(power)
    return row


def inertia(of: Balances, row: int) -> np.ndarray:
    """(P,) a coordinate's diagonal element of the mass matrix, mean over some poses, per unit of p."""
    signals = of.samples
    at = np.linspace(0, len(signals.q) - 1, _POSES).astype(int)
    rest, ddq = np.zeros((2 * _POSES, signals.q.shape[1])), np.zeros((2 * _POSES, signals.q.shape[1]))
    ddq[:_POSES, row] = 1.0
    tau = np.zeros((2 * _POSES, len(signals.robot.joints)))
    motion = Motion(np.tile(signals.q[at], (2, 1)), rest, ddq, tau, np.arange(2.0 * _POSES))
    rows = regressor(signals.robot, motion).matrix[:, row]
    return (rows[:_POSES] - rows[_POSES:]).mean(axis=0)
