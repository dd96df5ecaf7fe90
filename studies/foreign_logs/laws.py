"""What is hidden: forces as nature may have them, written apart from the project's catalogue."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class State:
    """time (N,) [s];  q, v, load (N, n) [rad, rad/s, N m]: load is what the bodies ask of a joint."""

    time: np.ndarray
    q: np.ndarray
    v: np.ndarray
    load: np.ndarray


Force = Callable[[State, int], np.ndarray]  # of a state and a joint (from 0): (N,)


@dataclass(frozen=True)
class Law:
    """A force of size one, drawn.

    dry     whether `force` is a level that the speed's sign turns round
    names   effects of the catalogue, any of which at the joint is right;  outside the catalogue: fair aliases
    """

    name: str
    force: Force
    dry: bool
    names: tuple[str, ...]

    def torque(self, state: State, k: int) -> np.ndarray:
        """(N,) that the motor has to give."""
        force = self.force(state, k)
        return force * np.sign(state.v[:, k]) if self.dry else force


Draw = Callable[[np.random.Generator, State, int], Law]


def _load(rng: np.random.Generator, s: State, k: int) -> Law:
    """Losses of a gear grow with the load, slightly less than in proportion."""
    typical, power = _rms(s.load[:, k]), rng.uniform(0.85, 1.15)
    return Law(
        "load",
        lambda s, k: (np.abs(s.load[:, k]) / typical) ** power,
        True,
        ("load_dependent_friction", "quadratic_load_friction"),
    )


def _stribeck(rng: np.random.Generator, s: State, k: int) -> Law:
    speed = rng.uniform(0.1, 0.25) * _rms(s.v[:, k])
    return Law("stribeck", lambda s, k: 1 / (1 + (s.v[:, k] / speed) ** 2), True, ("stribeck",))


def _viscous(rng: np.random.Generator, s: State, k: int) -> Law:
    """Grease: sub-linear, or quadratic as of churning oil."""
    speed, power = _rms(s.v[:, k]), rng.choice([rng.uniform(0.4, 0.7), rng.uniform(1.7, 2.3)])
    return Law(
        "viscous",
        lambda s, k: np.sign(s.v[:, k]) * (np.abs(s.v[:, k]) / speed) ** power,
        False,
        ("nonlinear_viscous",),
    )


def _ripple(rng: np.random.Generator, s: State, k: int) -> Law:
    """Of teeth or poles; not quite a sine."""
    order, phase = _turns(s, k, int(rng.integers(8, 60))), rng.uniform(0, 2 * np.pi)

    def force(s: State, k: int) -> np.ndarray:
        angle = order * s.q[:, k] + phase
        return np.cos(angle) + 0.1 * np.cos(2 * angle)

    return Law("ripple", force, False, ("torque_ripple", "kinematic_error"))


def _eccentric(rng: np.random.Generator, s: State, k: int) -> Law:
    """Friction of a gear wheel that is not quite round."""
    order, phase = _turns(s, k, rng.uniform(1.0, 4.0)), rng.uniform(0, 2 * np.pi)
    return Law(
        "eccentric",
        lambda s, k: 1 + np.cos(order * s.q[:, k] + phase),
        True,
        ("position_dependent_friction",),
    )


def _direction(rng: np.random.Generator, s: State, k: int) -> Law:
    """Viscous friction in one direction only, as of a worm that pushes or pulls."""
    way = rng.choice([-1.0, 1.0])
    return Law("direction", lambda s, k: way * np.maximum(way * s.v[:, k], 0), False, ("asymmetric_coulomb",))


def _hose(rng: np.random.Generator, s: State, k: int) -> Law:
    """A hose package that pulls ever less the further it is bent."""
    middle, width = np.median(s.q[:, k]), rng.uniform(0.5, 1.0) * np.ptp(s.q[:, k])
    return Law(
        "hose", lambda s, k: np.tanh((s.q[:, k] - middle) / width), False, ("joint_spring", "gravity_spring")
    )


def _cable(rng: np.random.Generator, s: State, k: int) -> Law:
    """A cable that tightens at this joint where its angle and the next one's add up to too much."""
    angle = _over_two(s, k)
    start = np.quantile(angle, rng.uniform(0.6, 0.8))
    return Law(
        "cable",
        lambda s, k: np.maximum(_over_two(s, k) - start, 0),
        False,
        ("slack_spring", "joint_spring", "gravity_spring"),
    )


def _stop(rng: np.random.Generator, s: State, k: int) -> Law:
    """A rubber stop at the end of the range."""
    start = np.quantile(s.q[:, k], rng.uniform(0.85, 0.93))
    return Law(
        "stop",
        lambda s, k: np.maximum(s.q[:, k] - start, 0) ** 1.5,
        False,
        ("slack_spring", "joint_spring", "gravity_spring"),
    )


def _brake(rng: np.random.Generator, s: State, k: int) -> Law:
    """A brake that grips again and again, for a second every three or so."""
    period, part = rng.uniform(2.3, 4.1), rng.uniform(0.2, 0.4)
    return Law("brake", lambda s, k: ((s.time % period) < part * period).astype(float), True, ())


SINGLE: Mapping[str, Draw] = {
    "load": _load,
    "stribeck": _stribeck,
    "viscous": _viscous,
    "ripple": _ripple,
    "eccentric": _eccentric,
    "direction": _direction,
    "hose": _hose,
}
OUTSIDE: Mapping[str, Draw] = {"cable": _cable, "stop": _stop, "brake": _brake}


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x)))) or 1.0


def _turns(s: State, k: int, periods: float) -> float:
    """Order that passes through `periods` periods over the joint's range."""
    return 2 * np.pi * float(periods) / max(float(np.ptp(s.q[:, k])), 1e-6)


def _over_two(s: State, k: int) -> np.ndarray:
    return s.q[:, k] + (s.q[:, k + 1] if k + 1 < s.q.shape[1] else 0.0)
