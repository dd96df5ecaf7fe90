"""A log's motor balances on a few hundred samples: what every hypothesis about its channels is tried on.

Positions and torques pass the same filter without phase shift; Φ is evaluated at a subset of the samples,
where any linear change of the channels (sign, unit, offset, order) can be applied after differentiation.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexmodels.coordinate import torque_of
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.conditioning.filters import without_phase
from pyident.conditioning.motion import Motion
from pyident.conditioning.smooth_motion import all_reached
from pyident.conditioning.weak_form import REACH, central_differences
from pyident.logs.log import Log
from pyident.regression.regressor import regressor
from pyident.rules.equation_checks import EQUATIONS

_ROWS = 1500  # samples at which Φ is evaluated
_BELL = 0.265  # samples of a bell's deviation, over the edge: there it leaves half as the filter does
_HOSE = 3  # powers of its angle in the torque of a hose at a joint


@dataclass(frozen=True)
class Samples:
    """Smoothed signals of a log.

    q, dq, ddq  (M, n) at the samples `at` (M,) of the log;  tau (N, joints), NaN where not logged
    direction   (M, joints) signs of the joints' speeds, smoothed as the torques that hold their friction are
    use         (M, joints) where a joint moves
    blurred     [s] on either side over which the smoothing smears a step
    by_bell     the same under a bell, which bends the motion a little, and does not ring behind a step
    """

    robot: Robot
    period: float
    at: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    tau: np.ndarray
    direction: np.ndarray
    use: np.ndarray
    blurred: float
    by_bell: "Samples | None" = None

    def torque(self) -> np.ndarray:
        """(M, joints) torques at the samples."""
        return self.tau[self.at]

    def shifted(self, k: int, shift: float | np.ndarray) -> np.ndarray:
        """(M,) torque of joint k (from 0), moved back by `shift` samples (one, or one per sample)."""
        tau, place = self.tau[:, k], np.clip(self.at + shift, 1, len(self.tau) - 3)
        i = place.astype(int)
        w = place - i
        a, b, c, d = (tau[i + j] for j in (-1, 0, 1, 2))  # Catmull and Rom
        return b + 0.5 * w * (c - a + w * (2 * a - 5 * b + 4 * c - d + w * (3 * (b - c) + d - a)))

    def every(self, step: int) -> "Samples":
        """One in so many of the samples at which Φ is evaluated."""
        part = {n: getattr(self, n)[::step] for n in ("at", "q", "dq", "ddq", "direction", "use")}
        return replace(self, **part, by_bell=None)

    def moved(self, matrix: np.ndarray, offset: np.ndarray) -> "Samples":
        """The same with coordinates  matrix q + offset."""
        q, dq, ddq = (x @ matrix.T for x in (self.q, self.dq, self.ddq))
        joints = self.direction.shape[1]
        direction, of_one = np.sign(dq[:, :joints]), np.count_nonzero(matrix[:joints, :joints], axis=1) == 1
        direction[:, of_one] = self.direction @ np.sign(matrix[:joints, :joints])[of_one].T
        use = _moving(self.robot, q, dq)
        return replace(self, q=q + offset, dq=dq, ddq=ddq, direction=direction, use=use, by_bell=None)


@dataclass(frozen=True)
class Balances:
    """Normal equations of every balance. Phi (M, n, P), motors first, of one motion.

    normal  (n, P, P) AᵀA of the samples in use
    """

    samples: Samples
    Phi: np.ndarray
    columns: tuple[str, ...]
    normal: np.ndarray

    @cached_property
    def joints(self) -> list[int]:
        """Those (from 0) that move and whose torque is logged."""
        use, tau = self.samples.use, self.torque
        moves = use.sum(axis=0) > EQUATIONS.fewest_moving
        return [k for k in range(use.shape[1]) if moves[k] and np.ptp(tau[:, k]) > 0]

    @cached_property
    def in_motion(self) -> "Balances":
        """Without what is near a joint's rest or reversal, where its friction is that of before, or none.

        The log is smoothed by a bell: what a filter that rings makes of that friction goes on for long.
        """
        own = self.samples.by_bell or self.samples
        step = max(own.period * float(np.median(np.diff(own.at))), 1e-300)
        window = np.ones(2 * int(np.ceil(own.blurred / step)) + 1)
        near = [np.convolve(still, window, "same") > 0 for still in (own.use == 0).T.astype(float)]
        return (self if own is self.samples else balances(own)).within(~np.array(near).T)

    def within(self, inside: np.ndarray) -> "Balances":
        """With those samples alone that are `inside` (M,) or (M, joints)."""
        use = self.samples.use * inside.reshape(len(inside), -1)
        return balances_of(replace(self.samples, use=use), self.Phi, self.columns)

    @cached_property
    def torque(self) -> np.ndarray:
        return self.samples.torque()

    def right(self, k: int, torques: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Aᵀy (P, C) and yᵀy (C,) of candidates (M, C) for the torque of joint k (from 0)."""
        used = self.samples.use[:, k] > 0
        y = torques[used]
        return self.Phi[used, k].T @ y, np.square(y).sum(axis=0)

    def variance(self, k: int, torque: np.ndarray | None = None) -> float:
        """Sum of squares of joint k's torque about its mean."""
        y = (self.torque[:, k] if torque is None else torque)[self.samples.use[:, k] > 0]
        return float(np.square(y - y.mean()).sum()) if len(y) else 0.0

    def beside(self, k: int, columns: np.ndarray) -> np.ndarray:
        """(U, P + C) the balance of joint k (from 0) and further columns (M, C), where it is used."""
        used = self.samples.use[:, k] > 0
        return np.column_stack([self.Phi[used, k], columns[used]])

    def left_beside(self, k: int, columns: np.ndarray) -> float:
        """Energy of the torque of joint k that neither its balance nor further columns (M, C) explain."""
        A, y = self.beside(k, columns), self.torque[self.samples.use[:, k] > 0, k]
        b = A.T @ y
        return max(float(y @ y - b @ solved(A.T @ A, b[:, None])[0][:, 0]), 0.0)

    def hose(self, k: int) -> np.ndarray:
        """(M, 3) what a spring, a hose or a counterweight at joint k holds: powers of its angle."""
        angle = self.samples.q[:, k]
        way = (angle - angle.mean()) / (np.ptp(angle) or 1.0)
        return way[:, None] ** np.arange(1, _HOSE + 1)

    @cached_property
    def beside_hoses(self) -> "Balances":
        """With one at every joint."""
        M, n = self.samples.use.shape
        hoses = np.zeros((M, self.Phi.shape[1], n * _HOSE))
        for k in range(n):
            hoses[:, k, k * _HOSE : (k + 1) * _HOSE] = self.hose(k)
        names = tuple(f"hose{power} of {k + 1}" for k in range(n) for power in range(1, _HOSE + 1))
        return balances_of(self.samples, np.concatenate([self.Phi, hoses], axis=2), self.columns + names)

    def left(self, k: int, torques: np.ndarray, without: str = "") -> np.ndarray:
        """(C,) energies of candidates (M, C) that the balance of joint k alone does not explain.

        without   a column whose parameter is zero
        """
        kept = [i for i, name in enumerate(self.columns) if name != without]
        b, yy = self.right(k, torques)
        p, _ = solved(self.normal[k][np.ix_(kept, kept)], b[kept])
        return np.maximum(yy - (b[kept] * p).sum(axis=0), 0.0)


def samples(robot: Robot, log: Log) -> Samples | None:
    """Smoothed signals of a log that holds every coordinate; None where it is too short."""
    n, T = len(log), log.period
    q = log.signals(list(robot.coordinates))
    tau = np.full((n, len(robot.joints)), np.nan)
    for k, _ in robot.numbered:
        if torque_of(k) in log.names:
            tau[:, k - 1] = log.frame[torque_of(k)].to_numpy(float)
    if robot.controller is not None:
        tau = (tau + np.concatenate([tau[:1], tau[:-1]])) / 2  # held: what acts around a sample
    edge = _edge(q[:, : len(robot.joints)])
    border = max(REACH, min(int(EQUATIONS.settled / edge), n // 10))
    if n < 20 * REACH or n - 2 * border < 60:
        return None
    from scipy.ndimage import gaussian_filter1d
    from scipy.signal import butter

    sections = np.asarray(butter(4, edge, output="sos"))
    at = np.arange(border, n - border, max(1, (n - 2 * border) // _ROWS))

    def smoothed(low_pass: Callable[[np.ndarray], np.ndarray]) -> Samples:
        motion = central_differences(low_pass(q), T)
        Q, dQ, ddQ = (x[at - REACH] for x in motion)
        direction = low_pass(np.sign(motion[1][:, : len(robot.joints)]))[at - REACH]
        torque = low_pass(np.nan_to_num(tau)) + 0 * tau
        return Samples(robot, T, at, Q, dQ, ddQ, torque, direction, _moving(robot, Q, dQ), T / edge)

    found = smoothed(lambda x: without_phase(sections, x))
    return replace(found, by_bell=smoothed(lambda x: gaussian_filter1d(x, _BELL / edge, axis=0)))


def balances(signals: Samples) -> Balances:
    """Φ at the samples, Coulomb friction smoothed as it is in the torques.

    Raises ValueError for laws that need more than a motion.
    """
    robot = signals.robot
    motion = Motion(
        signals.q, signals.dq, signals.ddq, np.nan_to_num(signals.torque()), signals.at * signals.period
    )
    Phi = regressor(robot, motion)
    for k in range(len(robot.joints)):
        if (name := parameter_name(k + 1, "coulomb", "coulomb")) in Phi.columns:
            Phi.matrix[:, k, Phi.columns.index(name)] = signals.direction[:, k]
    return balances_of(signals, Phi.matrix, tuple(Phi.columns))


def balances_of(signals: Samples, Phi: np.ndarray, columns: tuple[str, ...]) -> Balances:
    """Those of a Φ (M, n, P) at the samples."""
    normal = np.zeros((Phi.shape[1], len(columns), len(columns)))
    for row, matrix in enumerate(normal):
        A = Phi[signals.use[:, row] > 0, row] if row < signals.use.shape[1] else Phi[:, row]
        filled = np.flatnonzero(A.any(axis=0))
        matrix[np.ix_(filled, filled)] = A[:, filled].T @ A[:, filled]
    return Balances(signals, Phi, columns, normal)


def solved(normal: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """p (P, C) of least norm in scaled columns, and the pseudo-inverse (P, P) of the normal matrix."""
    scale = np.sqrt(np.diag(normal))
    scale = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    kept = values > EQUATIONS.determined * max(values[-1], 1e-300)
    half = vectors[:, kept] / np.sqrt(values[kept]) / scale[:, None]
    inverse = half @ half.T
    return inverse @ right, inverse


def _moving(robot: Robot, q: np.ndarray, dq: np.ndarray) -> np.ndarray:
    """Where a joint moves: never, if all it does is a tiny part of what the busiest one does."""
    n = len(robot.joints)
    speed, way = np.abs(dq[:, :n]), np.ptp(q[:, :n], axis=0)
    slow = EQUATIONS.slow * np.sqrt(np.mean(speed**2, axis=0))
    least = np.maximum(robot.settings.processing.dead_zone, slow)
    return ((speed > least) & (way > EQUATIONS.stands * way.max())).astype(float)


def _edge(q: np.ndarray) -> float:
    """The filter's edge as a share of the Nyquist frequency: well above what the joints' speeds hold.

    By the motion (N, joints), never by a robot file's cutoff: below what a motion holds, a filter passes for
    a delay. Where a coarse encoder has most of the speeds' energy, it is where the motion ends in its noise.
    """
    spectrum = np.square(np.abs(np.fft.rfft(np.diff(q, axis=0), axis=0)))
    energy = np.cumsum(spectrum.sum(axis=1))
    highest = float(np.searchsorted(energy, EQUATIONS.energy * energy[-1])) / max(len(energy) - 1, 1)
    return float(np.clip(min(EQUATIONS.above * highest, max(all_reached(q))), *EQUATIONS.band))
