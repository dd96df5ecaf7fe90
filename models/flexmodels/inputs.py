"""What a closed loop is fed with. Apart from `experiment`, which makes it: workers need no more than this."""

from dataclasses import dataclass

import numpy as np


class SimulationError(RuntimeError):
    """A model that cannot be simulated over its inputs; the message says why."""


@dataclass(frozen=True)
class Experiment:
    """Sampled inputs of the closed loop.

    time               (N,) [s], from 0
    reference          (N, joints) [rad or m]
    feedforward        (N, joints) [N m or N]
    on                 (N, joints) 1 where a servo drives its joint, 0 where it is switched off; None: always on
    start              (joints,) positions of servo-driven joints at the beginning; None: the first reference
    """

    time: np.ndarray
    reference: np.ndarray
    feedforward: np.ndarray
    on: np.ndarray | None = None
    start: np.ndarray | None = None
