"""What a motion tells, before it is run: the equations along its reference, each over the noise's level.

The reference is taken as followed exactly, sampled coarsely, transformed over time and divided by what the
sensors' noise leaves on each equation at each frequency. The Gram matrix of these equations is the
information matrix: a combination of parameters has the standard deviation that its inverse says.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import qr

from flexmodels.robot import Robot
from pyident.conditioning.fading import faded
from pyident.conditioning.motion import Motion
from pyident.conditioning.reversals.rubbing import rubs
from pyident.conditioning.weak_form import condition
from pyident.excitation.followed import followed
from pyident.excitation.fourier import Reference
from pyident.logs.log import Log
from pyident.regression.candidate_columns import effect_columns
from pyident.regression.regressor import regressor
from pyident.regression.spectrum import Band, Floor, equations, floor

_DRAWS = 4  # of the noise, over which its level is taken
_SLOW = 0.02  # of a joint's rms speed: near a reversal friction is not known
_ROUNDING = 1e-12  # of the largest column: what is left of one that is zero but for arithmetic
_INDEPENDENT = 1e-5  # of the largest, in scaled columns: less is a combination of the others


@dataclass(frozen=True)
class Yardstick:
    """What noise leaves on each equation. floor; period [s] and samples of the log that it was taken from."""

    floor: Floor
    period: float
    samples: int


def yardstick(robot: Robot, log: Log, noise: Mapping[str, float]) -> Yardstick:
    """The level of noise (channel -> standard deviation) on the equations of a noise-free log."""
    p = np.array(list(robot.linear_parameters.values()))
    rng = np.random.default_rng(0)
    clean = equations(robot, [faded(condition(log, robot))], [log.period])[0]
    expected = clean.y - clean.A @ p
    left = []
    for _ in range(_DRAWS):
        part = replace(condition(log.noisier(noise, rng), robot), use=clean.part.use)
        noisy = equations(robot, [part], [log.period])[0]
        left.append(noisy.y - noisy.A @ p - expected)
    return Yardstick(floor([clean.band] * _DRAWS, left), log.period, len(log))


@dataclass(frozen=True)
class Along:
    """Equations along a reference: A (n, E, P) over the noise's level."""

    motion: Motion
    use: np.ndarray
    band: Band
    level: np.ndarray
    gain: float
    A: np.ndarray

    @property
    def gram(self) -> np.ndarray:
        """(P, P) information."""
        flat = self.A.reshape(-1, self.A.shape[2])
        return flat.T @ flat

    def whitened(self, columns: Mapping[int, np.ndarray]) -> np.ndarray:
        """(n, E) of forces (N,) by row of the coordinates."""
        out = np.zeros(self.A.shape[:2])
        for row, force in columns.items():
            out[row] = self.gain * self.band.transform(force * self.use[:, row]) / self.level[row]
        return out

    def force(self, robot: Robot, joint: int, effect: str, values: Mapping[str, float]) -> np.ndarray:
        """(n, E, K) whitened columns of a law's linear parameters, the nonlinear ones at values."""
        found = effect_columns(robot, joint, effect, self.motion, values)
        return np.stack([self.whitened(rows) for rows in found.values()], axis=2)


def along(robot: Robot, measure: Yardstick, reference: Reference) -> Along:
    """The equations of a robot along a reference that is sampled more coarsely than a log."""
    motion = followed(robot, reference.time, reference.q, reference.dq, reference.ddq)
    period = float(reference.time[1] - reference.time[0])
    N = len(reference.time)
    top = min(float(measure.floor.frequencies[-1]), 0.4 / period)
    band = Band(N, max(2, int(top * N * period)), period)
    level = measure.floor.at(band)
    gain = float(np.sqrt(period / measure.period))  # finer sampling says as much more
    use = np.ones((N, len(robot.coordinates)))
    for rub in rubs(robot):
        v = np.abs(rub.of(reference.dq))
        use[:, rub.rows] *= (v >= max(_SLOW * np.sqrt(np.mean(v**2)), 1e-9))[:, None]
    Phi = regressor(robot, motion).matrix
    A = np.zeros((Phi.shape[1], 2 * band.bins, Phi.shape[2]))
    for c in range(Phi.shape[1]):
        used = np.flatnonzero(Phi[:, c].any(axis=0))
        A[c][:, used] = gain * band.transform(Phi[:, c, used] * use[:, c, None]) / level[c][:, None]
    return Along(motion, use, band, level, gain, A)


def independent(gram: np.ndarray) -> np.ndarray:
    """Numbers (r,) of columns of Φ that no others imitate, by Φᵀ Φ (P, P) of a motion rich enough to tell."""
    size = np.sqrt(np.diag(gram))
    present = np.flatnonzero(size > _ROUNDING * size.max())
    scaled = gram[np.ix_(present, present)] / np.outer(size[present], size[present])
    w, V = np.linalg.eigh(scaled)
    root = np.sqrt(np.maximum(w, 0))[:, None] * V.T
    _, R, order = qr(root, mode="economic", pivoting=True)  # pyright: ignore[reportAssignmentType]
    strength = np.abs(np.diag(R))
    return np.sort(present[order[: int((strength > _INDEPENDENT * strength[0]).sum())]])


def information(gram: np.ndarray, base: np.ndarray) -> float:
    """log det of the information (P, P) of columns `base` (r,), per column, in powers of e; −inf: no rank."""
    sign, value = np.linalg.slogdet(gram[np.ix_(base, base)])
    return float(value) / len(base) if sign > 0 else -np.inf
