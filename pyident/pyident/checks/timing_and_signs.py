"""Torques that belong to another instant, or have another sign, than the motion beside them.

The regression is solved with every joint's torque shifted by up to two samples either way. A torque held
from sample to sample, shifted by s samples, has under the hat function of a sample the mean
Σ_j B(j + 1/2 − s) τ_j  with the quadratic B-spline B (box * hat); others are interpolated. Signs show in the
friction, which must take energy, and in the stiffness, which must push back.
"""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.ndimage import uniform_filter1d

from flexmodels.coordinate import torque_of
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.conditioning.weak_form import REACH, condition
from pyident.logs.log import Log
from pyident.regression.spectrum import Equations, equations

SHIFTS = np.arange(-4, 5) / 2  # samples
_BETTER = 0.75  # of the residual's energy: a shift counts when it leaves less
_SMOOTH = 31  # bins over which a residual is averaged
_ROUNDS = 3  # of weighting by residuals
_SURE = 6.0  # standard deviations by which a friction or stiffness is negative
_DETERMINED = 1e-6  # of the largest singular value: below, a direction is noise
_PART = 1e-3  # of a direction that is noise: what a parameter that is known has of it
_SHARE = 0.1  # of the torque: what friction must take to show its sign
_BOX_ON_HAT = BSpline.basis_element(np.array([-1.5, -0.5, 0.5, 1.5]), extrapolate=False)


def timing(robot: Robot, log: Log) -> list[str]:
    """A sentence per joint whose torque fits its motion better some half samples earlier or later."""
    found = []
    for (k, _), left in zip(robot.numbered, shifted(robot, log), strict=True):
        best = int(np.argmin(left))
        if left[best] > _BETTER or SHIFTS[best] == 0:
            continue
        shift = SHIFTS[best]
        late = "late" if shift > 0 else "early"
        time = 1e3 * abs(shift) * log.period
        found.append(
            f"{log.source}: joint{k}.tau is {abs(shift):g} samples ({time:.3g} ms) {late}: moved back it "
            f"leaves {100 * left[best]:.0f} % of the residual; shift the column, or look for a slow current "
            f"loop (effect torque_delay)"
        )
    return found


def shifted(robot: Robot, log: Log) -> np.ndarray:
    """(joints, SHIFTS): the residual's energy with torque k moved back by a shift, of that without."""
    data = _equations(robot, log)
    out = []
    for k, _ in robot.numbered:
        A = data.A[k - 1]
        used = np.linalg.norm(A, axis=0) > 0
        Y = np.column_stack([_target(robot, log, data, k, s) for s in SHIFTS])
        level = _level(_left(A[:, used], data.y[k - 1][:, None])[:, 0])
        energy = np.square(_left(A[:, used] / level[:, None], Y / level[:, None])).sum(axis=0)
        out.append(energy / energy[SHIFTS == 0])
    return np.array(out)


def signs(robot: Robot, log: Log) -> list[str]:
    """A sentence per joint whose friction feeds energy in, else per deformation that pushes the wrong way."""
    data = _equations(robot, log)
    names, found = list(robot.linear_parameters), []
    for k, _ in robot.numbered:
        p, covariance = _fit(data, [k - 1])
        taken = _friction_power(data, k, names)
        used = np.flatnonzero(taken)
        power, variance = float(taken @ p), taken[used] @ covariance[np.ix_(used, used)] @ taken[used]
        spread = float(np.sqrt(max(variance, 0.0)))
        exchanged = float(np.mean(np.abs(data.part.target[:, k - 1] * data.part.motion.dq[:, k - 1])))
        if power < -_SURE * spread and power < -_SHARE * exchanged:
            found.append(
                f"{log.source}: joint{k}.tau has the wrong sign against joint{k}.e: friction would feed "
                f"energy in; give the column in [columns] a negative gain"
            )
    return found or _negative_springs(robot, log, data, names)


def _negative_springs(robot: Robot, log: Log, data: Equations, names: Sequence[str]) -> list[str]:
    p, covariance = _fit(data, range(len(robot.coordinates)))
    found = []
    for k, _ in robot.numbered:
        for i in range(1, 4):
            name = parameter_name(k, "stiffness", f"k[{i}]")
            if name not in names:  # a rigid joint, or one that only twists
                continue
            at = names.index(name)
            if p[at] < -_SURE * np.sqrt(covariance[at, at]):
                found.append(
                    f"{log.source}: joint{k}.eps[{i}] has the wrong sign: the joint would be of negative "
                    f"stiffness; give the column in [columns] a negative gain"
                )
    return found


def _friction_power(data: Equations, k: int, names: Sequence[str]) -> np.ndarray:
    """(P,) mean power that each parameter of dry and viscous friction takes at joint k, per unit."""
    de = data.part.motion.dq[:, k - 1]
    taken = np.zeros(len(names))
    for effect, power in (("coulomb", np.abs(de)), ("viscous", de**2)):
        name = parameter_name(k, effect, effect)
        if name in names:
            taken[names.index(name)] = np.mean(power)
    return taken


def _equations(robot: Robot, log: Log) -> Equations:
    return equations(robot, [condition(log, robot)], [log.period])[0]


def _target(robot: Robot, log: Log, data: Equations, k: int, shift: float) -> np.ndarray:
    """(E,) the transformed torque of joint k, moved back by `shift` samples."""
    tau = log.frame[torque_of(k)].to_numpy(float)
    n = np.arange(len(tau), dtype=float)
    if robot.controller is None:
        moved = CubicSpline(n, tau)(np.clip(n + shift, 0, len(tau) - 1))
    else:
        offsets = np.arange(-4, 5)
        weights = np.nan_to_num(_BOX_ON_HAT(offsets + 0.5 - shift))
        padded = np.pad(tau, 4, mode="edge")
        moved = sum(w * padded[4 + j : 4 + j + len(tau)] for j, w in zip(offsets, weights, strict=True))
    border = (len(tau) - len(data.part.target)) // 2
    assert border >= REACH
    kept = np.asarray(moved)[border : border + len(data.part.target)]
    return data.band.transform(kept * data.part.use[:, k - 1])


def _fit(data: Equations, rows: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Least squares of some rows by themselves: (P,) and its covariance (P, P), minimum norm.

    What the rows do not determine has an infinite variance.
    """
    A, y = data.A[rows], data.y[rows]
    level = np.ones_like(y)
    p, spread, unknown = _solved(A, y)
    for _ in range(_ROUNDS):
        level = np.array([_level(r) for r in y - A @ p])
        p, spread, unknown = _solved(A / level[:, :, None], y / level)
    covariance = spread @ spread.T * float(np.mean(((y - A @ p) / level) ** 2))
    covariance[unknown, unknown] = np.inf
    return p, covariance


def _solved(A: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    A, y = A.reshape(-1, A.shape[-1]), y.ravel()
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0] = 1.0
    R = np.asarray(np.linalg.qr(np.column_stack([A / scale, y]), mode="r"))
    U, s, Vt = np.linalg.svd(R[:, :-1], full_matrices=False)
    kept = s > _DETERMINED * s[0]
    spread = Vt[kept].T / s[kept] / scale[:, None]
    unknown = np.linalg.norm(Vt[~kept], axis=0) > _PART
    return spread @ (U.T @ R[:, -1])[kept], spread, unknown


def _left(A: np.ndarray, Y: np.ndarray) -> np.ndarray:
    """What A cannot explain of the columns of Y."""
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0] = 1.0
    U, s, _ = np.linalg.svd(A / scale, full_matrices=False)
    U = U[:, s > 1e-9 * s[0]]
    return Y - U @ (U.T @ Y)


def _level(residual: np.ndarray) -> np.ndarray:
    """(E,) the residual's own smoothed rms over frequency, real and imaginary parts together."""
    bins = len(residual) // 2
    power = (residual[:bins] ** 2 + residual[bins:] ** 2) / 2
    rms = np.sqrt(uniform_filter1d(power, min(_SMOOTH, bins), mode="nearest"))
    return np.tile(np.maximum(rms, 1e-9 * rms.max()), 2)
