"""What simulations miss of the logs' motion, asked for while they run: one that goes astray may take long."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from flexmodels.coordinate import motor_of
from pyident.simulation.replica import Repeat

FOLLOWS = 0.2  # of the motion: a simulation that misses more of it is no instrument


class NotFollowedError(Exception):
    """The simulated model does not follow the logs: it is no instrument."""


def missed(again: Sequence[Repeat], frames: Sequence[pd.DataFrame]) -> float:
    """The largest share of a joint's motion that simulations of logs miss."""
    return max(float(shares.max()) for shares in _each(again, frames))


def require_followed(again: Sequence[Repeat], frames: Sequence[pd.DataFrame]) -> None:
    """Raises NotFollowedError, with the joint that misses most of its motion, where that is too much."""
    shares = _each(again, frames)
    log = int(np.argmax([own.max() for own in shares]))
    joint = int(np.argmax(shares[log]))
    share = shares[log][joint]
    if not share < FOLLOWS:
        source = again[log].log.source
        raise NotFollowedError(
            f"joint{joint + 1} of the simulated model misses {100 * share:.0f} % of its motion in {source}"
        )


def _each(again: Sequence[Repeat], frames: Sequence[pd.DataFrame]) -> list[np.ndarray]:
    return [_missed(r, frame) for r, frame in zip(again, frames, strict=True)]


def astray(again: Sequence[Repeat]) -> Callable[[int, pd.DataFrame], None]:
    """What looks at simulations of the logs' plans, log by log, as they go.

    It raises NotFollowedError as soon as one has missed more than it may in all.
    """

    def look(number: int, frame: pd.DataFrame) -> None:
        own = again[number % len(again)]
        begun = frame.iloc[own.lead :]
        if len(begun) == 0:
            return
        # whatever follows, this much of the whole motion is missed in the end
        share = _missed(own, begun) * np.sqrt(len(begun) / len(own.log))
        if not share.max() < FOLLOWS:
            why = f"joint{np.argmax(share) + 1} of the simulated model leaves the motion of {own.log.source}"
            raise NotFollowedError(f"{why} within {len(begun) * own.log.period:.2g} s")

    return look


def _missed(again: Repeat, frame: pd.DataFrame) -> np.ndarray:
    """(joints,) shares of the whole motion, by the samples that there are."""
    names = [motor_of(k) for k in range(1, again.plan.reference.shape[1] + 1)]
    measured, made = again.log.signals(names), frame[names].to_numpy()
    moved = measured.std(axis=0)
    moved = np.maximum(moved, 1e-3 * moved.max())
    missed = np.std(measured[: len(made)] - made, axis=0) / moved
    return np.where(np.isfinite(missed), missed, np.inf)
