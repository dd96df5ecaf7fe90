"""What is drawn for a case, from a seed and its number alone."""

from dataclasses import dataclass

import numpy as np

from .machines import Error

KINDS = (
    "null", "strong", "medium", "weak", "outside", "difficult", "geometry", "pair", "strong", "triple",
)  # fmt: skip
SIZES = {
    "weak": (0.5, 1.5),
    "medium": (2.5, 3.5),
    "strong": (7.0, 9.0),
}  # over the torque's noise
RATES = (100, 125, 200, 250, 500)  # Hz
MOST_SAMPLES = 4000


@dataclass(frozen=True)
class Case:
    """kind    of KINDS
    difficult  whether gain, geometry, delay or a slow or short log make it so
    closed     whether MuJoCo moves the machine in a loop, else Pinocchio along a given motion
    duration   of the log to fit; the held-out one is half as long [s]
    """

    id: str
    seed: tuple[int, int]
    kind: str
    difficult: bool
    closed: bool
    rate: int
    duration: float
    periodic: bool
    slow: bool

    @property
    def rng(self) -> np.random.Generator:
        """For the machine and everything else of the case."""
        return np.random.default_rng([*self.seed, 1])


def case_list(seed: int, count: int) -> list[Case]:
    """The first `count` cases of a seed; more cases begin with the same ones."""
    return [_case(seed, i) for i in range(count)]


def _case(seed: int, number: int) -> Case:
    rng = np.random.default_rng([seed, number])
    kind = KINDS[number % len(KINDS)]
    difficult = kind == "difficult" or (kind not in ("null", "geometry") and rng.random() < 0.3)
    short = difficult and rng.random() < 0.3
    rate = int(rng.choice(RATES))
    duration = 10.0 if short else min(rng.uniform(15, 60), max(MOST_SAMPLES / rate, 10.0))
    return Case(
        id=f"{number + 1:03d}",
        seed=(seed, number),
        kind="null" if kind == "difficult" else kind,
        difficult=difficult,
        closed=bool(rng.random() < 0.4),
        rate=rate,
        duration=float(np.round(max(duration, 10.0), 1)),
        periodic=bool(rng.random() < 0.5),
        slow=bool(difficult and not short and rng.random() < 0.3),
    )


def small_errors(rng: np.random.Generator, joints: int) -> tuple[Error, ...]:
    """What a good drawing has wrong: 0.5 to 2 mm or 0.1° of one joint."""
    joint = int(rng.integers(1, joints + 1))
    if rng.random() < 0.5:
        return (_error(rng, "origin", "xyz", joint, rng.uniform(0.5e-3, 2e-3)),)
    return (_error(rng, "axis", "yz", joint, np.radians(0.1)),)


def large_error(rng: np.random.Generator, joints: int) -> Error:
    """What is to be found: 2 mm or 0.2°."""
    joint = int(rng.integers(1, joints + 1))
    if rng.random() < 0.5:
        return _error(rng, "origin", "xyz", joint, 2e-3)
    return _error(rng, "axis", "yz", joint, np.radians(0.2))


def _error(rng: np.random.Generator, name: str, letters: str, joint: int, size: float) -> Error:
    return Error(f"{name}[{rng.choice(list(letters))}]", joint, float(rng.choice([-1, 1]) * size))
