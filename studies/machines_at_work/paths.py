"""Paths of machines at work: legs from rest to rest, all joints at once or one after the other."""

from dataclasses import dataclass

import numpy as np

STYLES = ("all at once", "ramps of speed", "one at a time")


@dataclass(frozen=True)
class Path:
    """L legs of n joints, which stand still between them.

    start, lasts  (L,) [s];  origin, goal (L, n) [rad or m]
    ramp          share of a leg in which its speed rises, and falls; 0: a smooth quintic
    """

    start: np.ndarray
    lasts: np.ndarray
    origin: np.ndarray
    goal: np.ndarray
    ramp: float

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, speed, acceleration (N, n) at times (N,) [s]."""
        leg = np.clip(np.searchsorted(self.start, time, side="right") - 1, 0, None)
        lasts, way = self.lasts[leg, None], self.goal[leg] - self.origin[leg]
        s = np.clip((time - self.start[leg]) / self.lasts[leg], 0.0, 1.0)
        course = _ramped(s, self.ramp) if self.ramp else _quintic(s)
        x, dx, ddx = (values[:, None] for values in course)
        return self.origin[leg] + way * x, way * dx / lasts, way * ddx / lasts**2


def drawn_path(rng: np.random.Generator, sliders: np.ndarray, duration: float, style: str) -> Path:
    """Legs to random points at 0.6 to 1.2 rad/s, with dwells; `sliders` (n,) go a fifth as far."""
    n, alone = len(sliders), style == "one at a time"
    reach = np.where(sliders, 0.3, 1.5)
    speed, at, t = rng.uniform(0.6, 1.2, n) * reach / 1.5, np.zeros(n), 0.3
    legs: list[tuple[float, float, np.ndarray, np.ndarray]] = []
    while t < duration:
        goal = at.copy()
        if alone:  # out, to the other side and home, then the next joint's turn
            k, part = (len(legs) // 3) % n, len(legs) % 3
            goal[k] = 0.0 if part == 2 else reach[k] * rng.uniform(0.4, 0.8) * (1 - 2 * part)
        else:
            goal = reach * rng.uniform(-1, 1, n)
        pace = speed * (rng.uniform(0.6, 1.0) if alone else 1.0)
        lasts = max(0.5, 1.6 * float(np.max(np.abs(goal - at) / pace)))
        legs.append((t, lasts, at, goal))
        at, t = goal, t + lasts + (0.0 if alone else rng.uniform(0.1, 0.8))
    start, lasts, origin, goal = (np.array(part) for part in zip(*legs, strict=True))
    return Path(start, lasts, origin, goal, 0.0 if style == "all at once" else rng.uniform(0.15, 0.3))


def _quintic(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2, 60 * s * (1 - s) * (1 - 2 * s)


def _ramped(s: np.ndarray, r: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A trapezium of speed."""
    top = 1 / (1 - r)
    up, down = s < r, s > 1 - r
    x = np.where(
        up, top * s**2 / (2 * r), np.where(down, 1 - top * (1 - s) ** 2 / (2 * r), top * (s - r / 2))
    )
    dx = np.where(up, top * s / r, np.where(down, top * (1 - s) / r, top))
    moves = (s > 0) & (s < 1)
    return x, dx, np.where(moves & up, top / r, np.where(moves & down, -top / r, 0.0))
