"""How links swing on drives that bend, along their motors' motion, and what that changes in the torques.

A motor turns as q(t), its link as q − b. Drives, of stiffnesses K and dampings D, carry what their links ask
for, which is linear in the lag b and its rates where it is small (Spong 1987):

    F(q, q̇, q̈) − F_q b − F_v ḃ − M b̈ = K b + D ḃ

with F the loads of links that follow their motors and F_q, F_v, M = F_a their slopes. A link that follows its
motor does not tell how much of both inertias is the motor's, which does not lag: J of it is taken from M, and
J q̈ from F. Slowly, b is F / K;
near √(K / M) a link swings. Links of one arm swing together: M has all pairs of drives that bend. Between
samples b̈ is taken as a parabola (Numerov), right to the fourth order of the step; where a link swings too
fast for that, as a straight line, which is stable at any step.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np
from scipy.linalg import solve_banded

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.loads.bodies import carried_loads
from pyident.regression.loads.forces import as_they_are, link_forces_along
from pyident.regression.recent import Recent

_STEP = 1e-6  # rad and m, and per second
_LEAST = 0.05  # of the median inertia: bodies that were fitted badly may have less, or none, in some poses
_FOLLOWED = 3.0  # (ω h)²: up to 6 such a parabola is stable
_FARTHEST = 1.0  # rad, m: a spring too soft to hold its link, beyond all that is linear
_RUNG = 1e-3  # rad, and per second: what links begin to ring with
_slopes: Recent[np.ndarray] = Recent(32)


@dataclass(frozen=True)
class Spring:
    """A drive's compliance [rad/(N m), m/N], and the damping ratio of its link on it, inf: it only sags.

    rotor   inertia [kg m², kg] that a fit without springs gave to the link and that the motor has
    """

    compliance: float
    damping: float
    rotor: float = 0.0

    @property
    def swings(self) -> bool:
        """Whether the link has a swing of its own."""
        return math.isfinite(self.damping)


Springs = Mapping[int, Spring]  # by joint, from 1, in the order in which they are told
NO_SPRINGS: Springs = {}


def up_to(springs: Springs, joint: int) -> Springs:
    """A joint's, where links swing behind those before it; none where it has none."""
    if joint not in springs or not springs[joint].swings:
        return {joint: springs[joint]} if joint in springs else {}
    order = list(springs)
    return {k: springs[k] for k in order[: order.index(joint) + 1] if springs[k].swings}


def as_values(springs: Springs) -> tuple[tuple[str, float], ...]:
    """As named values."""
    return tuple((f"{k}.{name}", value) for k, s in springs.items() for name, value in asdict(s).items())


def from_values(values: Sequence[tuple[str, float]]) -> Springs:
    """Of `as_values`."""
    found: dict[int, dict[str, float]] = {}
    for name, value in values:
        joint, _, of = name.partition(".")
        found.setdefault(int(joint), {})[of] = value
    return {joint: Spring(**told) for joint, told in found.items()}


def carry(robot: Robot, motion: Motion, springs: Springs) -> bool:
    """Whether a log has times, and the robot's own bodies an inertia on every spring along its motion."""
    if motion.time is None or len(motion.q) <= 2:
        return False
    return all(typical_inertia(robot, motion, k) > spring.rotor for k, spring in springs.items())


def typical_inertia(robot: Robot, motion: Motion, joint: int) -> float:
    """The median of what the robot's own bodies have at a joint, from 1 [kg m², kg]."""
    return float(np.median(_slopes_at(robot, motion, joint)[2, joint - 1]))


def swung(robot: Robot, motion: Motion, springs: Springs) -> np.ndarray:
    """(n, N) what the links' torques change by where they swing on their drives' springs, by joint, from 1.

    They begin as links that lag slowly; 0 where springs do not hold them. Springs must carry something, as
    `carry` says.
    """
    slopes, swing = _swing(robot, motion, springs)
    load = carried_loads(robot, motion)[:, [k - 1 for k in springs]]
    rotors = np.array([spring.rotor for spring in springs.values()])
    load = load - rotors * motion.ddq[:, [k - 1 for k in springs]]
    first = load[:2] * [spring.compliance for spring in springs.values()]
    rates = swing.lags(load[:, :, None], first[:, :, None])[..., 0] if swing else np.zeros((3, *load.shape))
    return -np.einsum("rsit,rts->it", slopes, rates)


def ringing(robot: Robot, motion: Motion, springs: Springs) -> np.ndarray:
    """(2 S, n, N) what the links' torques change by where each begins to ring, by a lag and by a rate.

    Springs must carry something, as `carry` says.
    """
    slopes, swing = _swing(robot, motion, springs)
    N, S = len(motion.q), len(springs)
    if swing is None:
        return np.zeros((2 * S, slopes.shape[2], N))
    first = np.zeros((2, S, 2 * S))
    for i in range(S):
        first[:, i, i], first[1, i, S + i] = _RUNG, _RUNG * swing.h
    rates = swing.lags(np.zeros((N, S, 2 * S)), first)
    return -np.einsum("rsit,rtsk->kit", slopes, rates)


def _slopes_at(robot: Robot, motion: Motion, joint: int) -> np.ndarray:
    """(3, n, N): the links' torques per unit of a joint's angle, speed and acceleration."""

    def made() -> np.ndarray:
        found = []
        for name, step in (("q", _STEP), ("dq", _STEP), ("ddq", 1.0)):
            further = getattr(motion, name).copy()
            further[:, joint - 1] += step
            other = link_forces_along(robot, replace(motion, **{name: further}))
            found.append((other - as_they_are(robot, motion)) / step)
        return np.array(found)

    return _slopes.of((robot, motion), made, joint)


@dataclass(frozen=True)
class _Swing:
    """b̈ + damped ḃ + stiff b = masses⁻¹ load, of S links: matrices (N, S, S), at steps h."""

    stiff: np.ndarray
    damped: np.ndarray
    masses: np.ndarray
    h: float

    def lags(self, load: np.ndarray, first: np.ndarray) -> np.ndarray:
        """(3, N, S, R): lags and their rates under loads (N, S, R) from the two of `first` (2, S, R) on.

        0 where springs do not hold them.
        """
        try:
            force = np.linalg.solve(self.masses, load)
            with np.errstate(over="ignore", invalid="ignore"):
                lag = self._numerov(force, first)
        except np.linalg.LinAlgError:  # of bodies that no robot has
            return np.zeros((3, *load.shape))
        if not np.all(np.abs(lag) < _FARTHEST):
            return np.zeros((3, *load.shape))
        rate = np.gradient(lag, self.h, axis=0)
        return np.array([lag, rate, force - self.stiff @ lag - self.damped @ rate])

    def _numerov(self, force: np.ndarray, first: np.ndarray) -> np.ndarray:
        N, S, R = force.shape
        stiff, damped, h = self.stiff, self.damped, self.h
        inner = 10 if np.abs(stiff).max() * h * h < _FOLLOWED else 2  # beside 1 at the outer ones
        weight = h * h / (inner + 2)
        A, B, eye = weight * stiff, damped[1:-1] * h / 2, np.eye(S)
        right = np.concatenate([first, (force[2:] + inner * force[1:-1] + force[:-2]) * weight])
        lower, upper = 3 * S - 1, S - 1
        banded = np.zeros((lower + upper + 1, N * S))
        blocks = ((0, eye + A[2:] + B), (1, inner * A[1:-1] - 2 * eye), (2, eye + A[:-2] - B))
        for back, block in (*blocks, (None, np.broadcast_to(eye, (2, S, S)))):
            rows = np.arange(2, N) if back is not None else np.arange(2)
            for i, j in np.ndindex(S, S):
                at = (rows - (back or 0)) * S + j
                banded[upper + rows * S + i - at, at] = block[:, i, j]
        whole = right.reshape(N * S, R)
        return solve_banded((lower, upper), banded, whole, check_finite=False).reshape(N, S, R)


def _swing(robot: Robot, motion: Motion, springs: Springs) -> tuple[np.ndarray, _Swing | None]:
    """(3, S, n, N) slopes of the links' torques by lags and their rates; and how links swing.

    None: of bodies that no robot has.
    """
    own = [k - 1 for k in springs]
    slopes = np.stack([_slopes_at(robot, motion, k) for k in springs], axis=1)
    slopes[2, np.arange(len(own)), own] -= np.array([spring.rotor for spring in springs.values()])[:, None]
    F_q, F_v, M = (rate.transpose(2, 1, 0) for rate in slopes[:, :, own])  # (N, S, S)
    K = np.array([1 / spring.compliance for spring in springs.values()])
    M, own = M.copy(), np.arange(len(K))
    middle = np.median(M[:, own, own], axis=0)
    if (middle <= 0).any():
        return slopes, None
    M[:, own, own] = np.maximum(M[:, own, own], _LEAST * middle)
    D = 2 * np.array([s.damping for s in springs.values()]) * np.sqrt(middle * K)
    try:
        stiff, damped = np.linalg.solve(M, F_q + np.diag(K)), np.linalg.solve(M, F_v + np.diag(D))
    except np.linalg.LinAlgError:
        return slopes, None
    return slopes, _Swing(stiff, damped, M, float(np.median(np.diff(np.asarray(motion.time)))))
