"""What an experiment feeds into an FMU that follows the log contract."""

from collections.abc import Mapping

import numpy as np

from flexmodels.coordinate import of_joint, reference_of, start_of, start_speed_of, switch_of, torque_of
from flexmodels.inputs import Experiment


def input_names(references: Mapping[str, int], joints: int) -> list[str]:
    """Names of the columns of `input_values`."""
    if _is_plant(references):
        return [torque_of(k) for k in range(1, joints + 1)]
    signals = ("r", "tau_ff", "on") if _has_servos(references) else ("r", "tau_ff")
    return [of_joint(k, signal) for signal in signals for k in range(1, joints + 1)]


def input_values(references: Mapping[str, int], experiment: Experiment) -> np.ndarray:
    """(N, inputs): references, feed-forward torques and, of servos, whether they are on.

    Of a plant alone the torques, which are the feed-forward: nothing else drives it.
    """
    if _is_plant(references):
        return np.ascontiguousarray(experiment.feedforward)
    inputs = [experiment.reference, experiment.feedforward]
    if _has_servos(references):
        inputs.append(np.ones_like(experiment.reference) if experiment.on is None else experiment.on)
    return np.ascontiguousarray(np.hstack(inputs))


def start_values(references: Mapping[str, int], experiment: Experiment) -> dict[str, float]:
    """Speeds of the joints that do not set out from rest, and positions from which servos do."""
    speeds = () if experiment.speed is None else experiment.speed
    values = {start_speed_of(k): float(v) for k, v in enumerate(speeds, start=1)}
    if not _has_servos(references):
        return values
    start = experiment.reference[0] if experiment.start is None else experiment.start
    return values | {start_of(k): float(e) for k, e in enumerate(start, start=1)}


def _has_servos(references: Mapping[str, int]) -> bool:
    return switch_of(1) in references


def _is_plant(references: Mapping[str, int]) -> bool:
    return reference_of(1) not in references
