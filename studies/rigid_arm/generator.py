"""The arm's logs with one hidden law or none.

Masses and inertias are 10-25 % off the robot file, frictions are drawn. Hidden laws have other forms than the
catalogue's, and none of its code.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot
from pyident.logs.log import Log

from .arm import COULOMB, ROTOR, VISCOUS, Motion, arm, moved, recorded, torque_noise

DURATION, LOGS = 20.0, 3  # s
SIZES = {"strong": 8.0, "medium": 3.0, "weak": 1.5}  # rms of the hidden force over the torque's noise

Shape = Callable[[int, Motion, np.random.Generator], np.ndarray]


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
    coulomb, viscous, rotor = (size * rng.uniform(0.8, 1.2, 6) for size in (COULOMB, VISCOUS, ROTOR))
    law_seed = int(rng.integers(2**31))
    logs = []
    for i in range(LOGS):
        motion = moved(true, rng, DURATION)
        tau = motion.load + rotor * motion.a + coulomb * np.sign(motion.v) + viscous * motion.v
        noise = torque_noise(tau)
        if case.law:
            k = case.joint - 1
            shape = (SINGLE | OUTSIDE)[case.law](k, motion, np.random.default_rng(law_seed))
            tau[:, k] += SIZES[case.size] * noise[k] * shape / np.sqrt(np.mean(shape**2))
        logs.append(recorded(motion, tau, noise, rng, f"log {i}"))
    return logs


def _off(robot: Robot, rng: np.random.Generator) -> Robot:
    """With masses and inertias 10 to 25 % off, each link by one factor so that it stays a body."""
    factors = 1 + rng.choice([-1, 1], len(robot.links)) * rng.uniform(0.1, 0.25, len(robot.links))
    values = {
        name: value * factors[int(name.split(".")[0].removeprefix("link")) - 1]
        for name, value in robot.parameters.items()
        if name.startswith("link")
    }
    return robot.with_parameters(values)
