"""Sound logs of arms with a strong law that their model lacks: a case for a diagnosis, not for a refusal."""

from collections.abc import Callable, Iterator

import numpy as np

from pyident.logs.log import Log

from .good_logs import Case, scara
from .swings import Motion, recorded, six_axes

Law = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def lacking(draws: int = 3, seed: int = 91) -> Iterator[Case]:
    """Every law at joints and in sizes drawn at random, of rigid arms by Pinocchio."""
    for robot in filter(None, (six_axes(), scara())):
        for i, (name, law) in enumerate(LAWS.items()):
            for draw in range(draws):
                rng = np.random.default_rng([seed, i, draw])
                k, size = int(rng.integers(1, len(robot.joints) + 1)), float(rng.uniform(0.3, 2.0))
                frame = recorded(robot, Motion(speed=float(rng.uniform(0.4, 1.0))), seed + draw)
                q, tau = frame[f"joint{k}.e"].to_numpy(), frame[f"joint{k}.tau"].to_numpy()
                dq = np.gradient(q, frame["time"].to_numpy())
                more = law(_unit(q), dq / dq.std(), tau / tau.std())
                frame[f"joint{k}.tau"] += size * tau.std() * more / max(float(more.std()), 1e-300)
                case = f"{robot.name}, {name} at joint {k}, {size:.1f} times its torque"
                yield case, robot, Log(frame, f"{name}.csv")


def _unit(x: np.ndarray) -> np.ndarray:
    """From −1 to 1."""
    return 2 * (x - x.min()) / np.ptp(x) - 1


def _rubbing(x: np.ndarray, travel: float) -> np.ndarray:
    """Friction that turns round over a travel (Dahl 1968)."""
    z, step = np.zeros(len(x)), np.diff(x)
    for i, way in enumerate(step):
        z[i + 1] = np.sign(way) + (z[i] - np.sign(way)) * np.exp(-abs(way) / travel)
    return z


LAWS: dict[str, Law] = {
    "a spring": lambda x, v, tau: x,
    "a hose": lambda x, v, tau: 0.5 * x + x**3,
    "a hose that is tight at one end": lambda x, v, tau: np.exp(3 * x),
    "an end stop of rubber": lambda x, v, tau: np.maximum(np.abs(x) - 0.7, 0) * np.sign(x),
    "a counterweight": lambda x, v, tau: np.sin(1.5 * x + 0.4),
    "a spring with a dead zone": lambda x, v, tau: np.maximum(np.abs(x) - 0.3, 0) * np.sign(x),
    "load-dependent friction": lambda x, v, tau: np.abs(tau) * np.tanh(30 * v),
    "friction that falls with speed": lambda x, v, tau: np.exp(-np.square(3 * v)) * np.tanh(30 * v),
    "friction in one direction": lambda x, v, tau: (v > 0) * np.tanh(30 * v),
    "friction that depends on the angle": lambda x, v, tau: (1 + x) * np.tanh(30 * v),
    "friction that warms up": lambda x, v, tau: np.linspace(2, 0, len(v)) * np.tanh(30 * v),
    "friction of the cube of the speed": lambda x, v, tau: v**3,
    "a hose that rubs": lambda x, v, tau: x + 0.6 * _rubbing(x, 0.1),
    "friction of bristles": lambda x, v, tau: _rubbing(x, 0.004),
    "friction of bristles that are long": lambda x, v, tau: _rubbing(x, 0.02),
    "a torque ripple": lambda x, v, tau: np.sin(20 * x),
}
