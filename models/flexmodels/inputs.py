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
    on                 (N, joints) 1 where a servo drives, 0 where it is switched off; None: always on
    start              (joints,) where servo-driven joints set out; None: at the first reference
    began              [s] time of the first sample in the log that it comes from
    speed              (joints,) with which the joints set out [rad/s or m/s]; None: at rest
    """

    time: np.ndarray
    reference: np.ndarray
    feedforward: np.ndarray
    on: np.ndarray | None = None
    start: np.ndarray | None = None
    began: float = 0.0
    speed: np.ndarray | None = None
