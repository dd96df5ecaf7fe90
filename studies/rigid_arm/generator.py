"""A rigid six-axis arm that others simulate: Pinocchio's inverse dynamics, friction of its own.

Geometry is that of the shipped tx40; masses and inertias are 10-25 % off its file, frictions are drawn, no
controller is known. Torques and encoders are noisy. Hidden laws have other forms than the catalogue's, and
none of its code.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing
from pyident.logs.log import Log

RATE, DURATION, LOGS = 100.0, 20.0, 3
COULOMB = np.array([8.0, 9.0, 6.0, 2.5, 3.0, 2.0])
VISCOUS = np.array([9.0, 7.0, 4.0, 1.5, 2.0, 0.8])
ROTOR = np.array([0.35, 0.4, 0.1, 0.04, 0.06, 0.02])  # kg m²
REACH = np.array([1.2, 0.8, 0.9, 1.5, 1.2, 1.8])
TORQUE_NOISE, ENCODER_NOISE = 0.004, 2e-6  # of the joint's rms torque; rad
SIZES = {"strong": 8.0, "medium": 3.0, "weak": 1.5}  # rms of the hidden force over the torque's noise

Shape = Callable[[int, "Motion", np.random.Generator], np.ndarray]


@dataclass(frozen=True)
class Motion:
    """q, v, load (N, 6) [rad, rad/s, N m]."""

    q: np.ndarray
    v: np.ndarray
    load: np.ndarray


@dataclass(frozen=True)
class Case:
    """kind: null, single or outside;  law, joint (from 1): what is hidden;  size: of SIZES."""

    id: str
    kind: str
    law: str = ""
    joint: int = 0
    size: str = ""
    seed: int = 0


def _load(k: int, m: Motion, _: np.random.Generator) -> np.ndarray:
    return np.abs(m.load[:, k]) * np.tanh(m.v[:, k] / 0.003)


def _stribeck(k: int, m: Motion, rng: np.random.Generator) -> np.ndarray:
    slow = rng.uniform(0.1, 0.2) * np.sqrt(np.mean(m.v[:, k] ** 2))
    return np.tanh(m.v[:, k] / 0.003) / (1 + (m.v[:, k] / slow) ** 2)


def _viscous(k: int, m: Motion, rng: np.random.Generator) -> np.ndarray:
    return np.sign(m.v[:, k]) * np.abs(m.v[:, k]) ** rng.uniform(1.6, 2.4)


def _ripple(k: int, m: Motion, rng: np.random.Generator) -> np.ndarray:
    order = 2 * int(rng.integers(30, 110))
    return np.cos(order * m.q[:, k] + rng.uniform(0, 6))


def _position(k: int, m: Motion, rng: np.random.Generator) -> np.ndarray:
    return np.tanh(m.v[:, k] / 0.003) * np.cos(rng.uniform(2, 4) * m.q[:, k] + rng.uniform(0, 6))


def _neighbour(k: int, m: Motion, _: np.random.Generator) -> np.ndarray:
    """Friction that grows with the neighbour's speed, which no law of the catalogue does."""
    return np.tanh(m.v[:, k] / 0.003) * np.abs(m.v[:, (k + 1) % 6])


def _cable(k: int, m: Motion, rng: np.random.Generator) -> np.ndarray:
    """A cable over two joints that tightens beyond an angle."""
    angle = m.q[:, k] + m.q[:, (k + 1) % 6]
    return np.maximum(angle - np.quantile(angle, rng.uniform(0.5, 0.7)), 0)


SINGLE: dict[str, Shape] = {
    "load_dependent_friction": _load,
    "stribeck": _stribeck,
    "nonlinear_viscous": _viscous,
    "torque_ripple": _ripple,
    "position_dependent_friction": _position,
}
OUTSIDE: dict[str, Shape] = {"neighbour": _neighbour, "cable": _cable}


def arm() -> Robot:
    """The robot file that the diagnosis gets."""
    robot = load_robot("tx40")
    basic = ("motor_inertia", "coulomb", "viscous", "offset")
    joints = tuple(replace(j, values={n: v for n, v in j.values.items() if n in basic}) for j in robot.joints)
    plain: dict[str, Any] = {
        "transmission": None,
        "columns": {},
        "controller": None,
        "processing": Processing(),
    }
    return replace(robot, joints=joints, **plain)


def case_list(seed: int, nulls: int) -> list[Case]:
    """Every law of the list once at a drawn joint and size, and nulls."""
    rng = np.random.default_rng(seed)
    cases = [Case(f"n{i}", "null", seed=int(rng.integers(2**31))) for i in range(nulls)]
    for kind, laws in (("single", SINGLE), ("outside", OUTSIDE)):
        for law in laws:
            joints = (2, 3) if law == "load_dependent_friction" else (1, 2, 3, 4, 5, 6)
            joint, size = int(rng.choice(joints)), str(rng.choice(["strong", "medium"]))
            cases.append(Case(f"{law[:4]}{joint}", kind, law, joint, size, int(rng.integers(2**31))))
    return cases


def logs_of(case: Case) -> list[Log]:
    """LOGS logs along sums of sines; the last is to be held out."""
    rng = np.random.default_rng(case.seed)
    true = _off(arm(), rng)
    own = (
        COULOMB * rng.uniform(0.8, 1.2, 6),
        VISCOUS * rng.uniform(0.8, 1.2, 6),
        ROTOR * rng.uniform(0.8, 1.2, 6),
    )
    law_seed = int(rng.integers(2**31))
    return [_log(case, true, own, law_seed, rng, f"log {i}") for i in range(LOGS)]


def _log(case: Case, true: Robot, own: Any, law_seed: int, rng: np.random.Generator, name: str) -> Log:
    coulomb, viscous, rotor = own
    time = np.arange(0, DURATION, 1 / RATE)
    q, v, a = _path(time, rng)
    load = _inverse_dynamics(true, q, v, a)
    tau = load + rotor * a + coulomb * np.sign(v) + viscous * v
    noise = TORQUE_NOISE * np.sqrt(np.mean(tau**2, axis=0))
    if case.law:
        k = case.joint - 1
        shape = (SINGLE | OUTSIDE)[case.law](k, Motion(q, v, load), np.random.default_rng(law_seed))
        tau[:, k] += SIZES[case.size] * noise[k] * shape / np.sqrt(np.mean(shape**2))
    tau = tau + noise * rng.standard_normal(tau.shape)
    q = q + ENCODER_NOISE * rng.standard_normal(q.shape)
    columns = {"time": time} | {f"joint{k + 1}.e": q[:, k] for k in range(6)}
    return Log(pd.DataFrame(columns | {f"joint{k + 1}.tau": tau[:, k] for k in range(6)}), name)


def _path(time: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q, v, a = (np.zeros((len(time), 6)) for _ in range(3))
    for k in range(6):
        for harmonic in range(1, 7):
            omega = 2 * np.pi * 0.06 * harmonic * (1 + 0.05 * rng.random())
            size, phase = REACH[k] * rng.uniform(0.2, 0.6) / harmonic, rng.uniform(0, 2 * np.pi)
            q[:, k] += size * np.sin(omega * time + phase)
            v[:, k] += size * omega * np.cos(omega * time + phase)
            a[:, k] -= size * omega**2 * np.sin(omega * time + phase)
    return q, v, a


def _off(robot: Robot, rng: np.random.Generator) -> Robot:
    """With masses and inertias 10 to 25 % off, each link by one factor so that it stays a body."""
    factors = 1 + rng.choice([-1, 1], len(robot.links)) * rng.uniform(0.1, 0.25, len(robot.links))
    values = {
        name: value * factors[int(name.split(".")[0].removeprefix("link")) - 1]
        for name, value in robot.parameters.items()
        if name.startswith("link")
    }
    return robot.with_parameters(values)


def _inverse_dynamics(robot: Robot, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    import pinocchio as pin  # pyright: ignore[reportMissingImports]

    model = pin.Model()
    model.gravity.linear = np.array(robot.gravity)
    parent, axes = 0, np.eye(3)
    for joint, link in zip(robot.joints, robot.links, strict=True):
        triad = joint.triad
        place = pin.SE3(axes.T @ triad, axes.T @ np.array(joint.origin))
        parent = model.addJoint(parent, pin.JointModelRX(), place, f"joint{model.njoints}")
        model.appendBodyToJoint(parent, _body(link, triad), pin.SE3.Identity())
        axes = triad
    data = model.createData()
    return np.array([pin.rnea(model, data, *x) for x in zip(q, v, a, strict=True)])


def _body(link: Any, triad: np.ndarray) -> Any:
    import pinocchio as pin  # pyright: ignore[reportMissingImports]

    com = np.array(link.ms) / link.m
    xx, xy, xz, yy, yz, zz = link.J
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    J_com = J - link.m * (com @ com * np.eye(3) - np.outer(com, com))
    return pin.Inertia(link.m, triad.T @ com, triad.T @ J_com @ triad)
