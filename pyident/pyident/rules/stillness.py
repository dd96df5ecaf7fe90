"""When a signal counts as standing still."""

from dataclasses import dataclass

import numpy as np

from pyident.rules.rule import in_range, rule


@dataclass(frozen=True)
class StillnessRules:
    """What is motion, and what is arithmetic."""

    constant: float = rule(
        1e-9,
        "a signal's largest value",
        "what changes by less is rounding; one count of 26 bits in a turn is some 30 times as much",
        "arithmetic: far above what doubles resolve, far below what encoders do",
    )

    def __post_init__(self) -> None:
        in_range(self, "stillness", 0, 1, "constant")


STILLNESS = StillnessRules()


def stands_still(*courses: np.ndarray, beside: float = 0.0) -> bool:
    """Whether a signal's values, (N,) per recording, are one and the same in all of them.

    beside   largest value of the signals of its kind, such as every joint's position; its own counts anyway
    """
    values = np.concatenate(courses)
    return bool(np.ptp(values) <= STILLNESS.constant * max(float(np.abs(values).max()), beside))
