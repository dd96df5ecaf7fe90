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
    """

    time: np.ndarray
    reference: np.ndarray
    feedforward: np.ndarray
