"""Torques in another unit: against the other joints' torques, and against the robot file's masses.

The robot file is a witness of the order of magnitude and nothing else; no identified value comes from it.
"""

from collections.abc import Iterator

import numpy as np

from flexmodels.coordinate import joint_name, motor_of, torque_of
from flexmodels.robot import Robot
from pyident.checks.balances import Balances, solved
from pyident.checks.defect import Defect
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.log_checks import LOG_CHECKS


def scale(of: Balances, source: str) -> Iterator[Defect]:
    """At most one defect: one torque against the others, all of them or one joint's against the file."""
    yield from next(filter(None, (list(f(of, source)) for f in (_one_torque, _against_file, _one_joint))), [])


def shared(of: Balances, joints: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normal matrices (J, P, P), right sides (J, P) and energies (J,) of joints, over their variances."""
    variance = np.array([max(of.variance(k), 1e-300) for k in joints])
    right, energy = zip(*(of.right(k, of.torque[:, k : k + 1]) for k in joints), strict=True)
    b = np.array([r[:, 0] for r in right]) / variance[:, None]
    return of.normal[joints] / variance[:, None, None], b, np.array(energy)[:, 0] / variance


def _one_torque(of: Balances, source: str) -> Iterator[Defect]:
    """Joints share the links behind them: a torque times a number shows in the others' balances."""
    joints = of.joints
    if len(joints) < 2:
        return
    normal, b, energy = shared(of, joints)
    together, right = normal.sum(axis=0), b.sum(axis=0)
    p = solved(together, right)[0]
    now = float(energy.sum() - right @ p)
    if now < len(joints) * LOG_CHECKS.material**2:
        return
    found = []
    for i, k in enumerate(joints):
        G = np.block([[together, -b[i][:, None]], [-b[i][None], energy[i].reshape(1, 1)]])
        c = np.append(right - b[i], 0.0)
        solution = solved(G, c)[0]
        factor, values = float(solution[-1]), solution[:-1]
        if abs(factor) < 1e-9:
            continue
        own = values @ normal[i] @ values - 2 * factor * b[i] @ values + factor**2 * energy[i]
        others = (
            energy.sum() - energy[i] - 2 * (right - b[i]) @ values + values @ (together - normal[i]) @ values
        )
        found.append((float(own / factor**2 + others), factor, k))
    left, factor, k = min(found, default=(np.inf, 1.0, 0))
    if _off(factor) and left < LOG_CHECKS.better * now:
        factor, k = _by_masses(of, factor, k)
        yield Defect(
            "gross",
            "unit",
            torque_of(k + 1),
            f"{source}: {torque_of(k + 1)} should be {factor:.3g} times as large to agree with the other "
            "joints' "
            f"torques; check its unit (N m), its gear ratio and its sign in the mapping",
        )


def _off(factor: float) -> bool:
    return not 1 / LOG_CHECKS.torque_scale <= factor <= LOG_CHECKS.torque_scale


def _by_masses(of: Balances, factor: float, k: int) -> tuple[float, int]:
    """The factor of a torque, and its joint (from 0); of another one where the file's masses agree with that
    torque and not with the other: of two that share a body either may seem the wrong one.
    """
    told = {joint: found for joint in of.joints if (found := file_factor(of, [joint])) is not None}
    if k not in told or _off(told[k]):
        return factor, k
    worst = max(told, key=lambda joint: abs(np.log(told[joint])))
    return (1 / told[worst], worst) if _off(told[worst]) else (factor, k)


def _against_file(of: Balances, source: str) -> Iterator[Defect]:
    factor = file_factor(of)
    if factor is None:
        return
    size = max(factor, 1 / factor)
    if size > LOG_CHECKS.prior_doubtful:
        yield Defect(
            "gross" if size > LOG_CHECKS.prior_gross else "doubtful",
            "unit",
            "",
            f"{source}: masses and inertias would be {factor:.3g} times those of the robot file; check the "
            "units "
            f"of the torques (N m, at the joint) and of the positions (rad or m), the rate, and that the "
            "file "
            f"describes this robot",
        )


def _one_joint(of: Balances, source: str) -> Iterator[Defect]:
    """A heavy joint's own inertia against the file's; of a light one the motor's, often left out, is most."""
    size = {
        k: float(np.square(of.Phi[:, k] @ _masses(of.samples.robot, of.columns)).sum()) for k in of.joints
    }
    for k, own in size.items():
        factor = file_factor(of, [k])
        if factor is None or own < EQUATIONS.heavy * max(size.values()):
            continue
        if max(factor, 1 / factor) > LOG_CHECKS.prior_gross:
            yield Defect(
                "gross",
                "unit",
                torque_of(k + 1),
                f"{source}: what {joint_name(k + 1)} moves would be {factor:.3g} times the robot file's; "
                f"check the units of {torque_of(k + 1)} and {motor_of(k + 1)}, and the gear ratio",
            )


def file_factor(of: Balances, joints: list[int] | None = None) -> float | None:
    """By what the robot file's masses must be multiplied to explain the torques; None where they cannot say.

    Motor inertias and friction are free where that leaves the masses something to say.
    """
    masses = _masses(of.samples.robot, of.columns)
    joints = of.joints if joints is None else joints
    if not masses.any() or not joints:
        return None
    for inertia in (True, False):
        normal, right, energy = _reduced(of, joints, masses, inertia)
        p = solved(normal, right)[0]
        rest = np.arange(1, len(p))
        alone = solved(normal[np.ix_(rest, rest)], right[rest])[0]
        gain = float(right @ p - right[rest] @ alone)
        left = energy - float(right @ p)
        if p[0] > 0 and gain > max(EQUATIONS.speaks * energy, left):
            return float(p[0])
    return None


def _reduced(
    of: Balances, joints: list[int], masses: np.ndarray, inertia: bool
) -> tuple[np.ndarray, np.ndarray, float]:
    """Normal equations of one factor of all masses, and every joint's own friction (and motor inertia)."""
    free = 4 if inertia else 3
    size = 1 + free * len(joints)
    normal, right, total = np.zeros((size, size)), np.zeros(size), 0.0
    for i, k in enumerate(joints):
        used = of.samples.use[:, k] > 0
        de, dde, y = of.samples.dq[used, k], of.samples.ddq[used, k], of.torque[used, k]
        own = [np.sign(de), de, np.ones(len(de)), *([dde] if inertia else [])]
        A = np.column_stack([of.Phi[used, k] @ masses, *own])
        variance = max(of.variance(k), 1e-300)
        at = [0, *range(1 + i * free, 1 + (i + 1) * free)]
        normal[np.ix_(at, at)] += A.T @ A / variance
        right[at] += A.T @ (y - y.mean()) / variance
        total += 1.0
    return normal, right, total


def _masses(robot: Robot, columns: tuple[str, ...]) -> np.ndarray:
    """(P,) the file's link parameters and motor inertias, zero for every law."""
    values = robot.parameters
    kept = [name.startswith("link") or name.endswith(".J_m") for name in columns]
    return np.array([values[name] if keep else 0.0 for name, keep in zip(columns, kept, strict=True)])
