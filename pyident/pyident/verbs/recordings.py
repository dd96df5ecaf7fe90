"""What a file holds before it is a log: its channels, and the mapping that it seems to want."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pyident.verbs.inputs import Model, robot_of

if TYPE_CHECKING:
    from pyident.inspection.proposal import Proposal

_TIMES = ("time", "t", "timestamp")


def channels_of(path: str | Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time (N,) [s], or sample numbers where there is none, and every numeric channel (N,) float32.

    Raises LogError.
    """
    from pyident.logs.formats.read import read_recording

    columns = read_recording(Path(path)).columns
    numeric = {name: np.asarray(v) for name, v in columns.items() if np.asarray(v).dtype.kind in "fiu"}
    longest = max((len(v) for v in numeric.values()), default=0)
    whole = {name: v for name, v in numeric.items() if v.ndim == 1 and len(v) == longest}
    name = next((n for n in whole if n.lower() in _TIMES), None)
    time = np.arange(longest, dtype=float) if name is None else np.asarray(whole.pop(name), float)
    return time, {n: np.ascontiguousarray(v, np.float32) for n, v in whole.items()}


def proposed_mapping(files: Sequence[str | Path], model: Model | None = None) -> "Proposal":
    """Signals, joints, units and signs of a recording's columns as far as they can be guessed.

    model   whose joints and equations are witnesses
    Raises LogError, RobotError.
    """
    from pyident.inspection.inspect_log import inspect_log

    return inspect_log(files, None if model is None else robot_of(model))
