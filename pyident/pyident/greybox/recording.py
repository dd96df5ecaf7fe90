"""What a log and a model of any kind have in common: the model's inputs, and the outputs to be met."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flexmodels.inputs import SimulationError
from pyident.logs.log import Log, LogError

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Recording:
    """One log as a model sees it.

    time       (N,) [s], evenly spaced, from the log
    inputs     name -> (N,)
    measured   (N, S) in the order of `outputs`
    units      of the outputs
    """

    source: str
    time: np.ndarray
    inputs: Mapping[str, np.ndarray]
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    measured: np.ndarray


class Simulate(Protocol):
    """Outputs under a recording's inputs for several sets of values, (sets, N, names)."""

    def __call__(
        self,
        recording: Recording,
        sets: Sequence[Mapping[str, float]],
        names: Sequence[str],
        progress: Progress | None = None,
    ) -> np.ndarray: ...


@dataclass(frozen=True)
class Signals:
    """What a model offers: inputs with the value that holds where a log is silent, and outputs with units."""

    inputs: Mapping[str, float | None]
    outputs: Mapping[str, str]


def recording(log: Log, signals: Signals) -> tuple[Recording, tuple[str, ...]]:
    """The part of a log that the model knows, and notes. Raises LogError."""
    frame = log.frame
    outputs = tuple(name for name in signals.outputs if name in frame)
    if not outputs:
        offered = ", ".join([*signals.outputs][:6]) or "none"
        raise LogError(f"{log.source}: no column is an output of the model; its outputs are {offered}")
    silent = [name for name in signals.inputs if name not in frame]
    unknown = [name for name in silent if signals.inputs[name] is None]
    if unknown:
        raise LogError(
            f"{log.source}: column {unknown[0]} is missing, an input of the model that has no start value"
        )
    notes = []
    if silent:
        values = ", ".join(f"{name} = {signals.inputs[name]:g}" for name in silent[:4])
        more = f" and {len(silent) - 4} more" if len(silent) > 4 else ""
        notes.append(f"{log.source}: inputs without a column keep their start value: {values}{more}")
    taken = Recording(
        source=log.source,
        time=frame["time"].to_numpy(dtype=float),
        inputs={name: frame[name].to_numpy(dtype=float) for name in signals.inputs if name in frame},
        outputs=outputs,
        units=tuple(signals.outputs[name] for name in outputs),
        measured=frame[list(outputs)].to_numpy(dtype=float),
    )
    return taken, tuple(notes)


def misses(
    recordings: Sequence[Recording], simulate: Simulate, values: Mapping[str, float]
) -> list[np.ndarray]:
    """Measured less simulated, (N, S) per recording. Raises SimulationError, also for what is no number."""
    found = [r.measured - simulate(r, [values], r.outputs)[0] for r in recordings]
    require_numbers(recordings, found)
    return found


def require_numbers(recordings: Sequence[Recording], missed: Sequence[np.ndarray]) -> None:
    """Raises SimulationError where what a model misses, (N, S) per recording, is no number."""
    for r, left in zip(recordings, missed, strict=True):
        if len(lost := np.argwhere(~np.isfinite(left))):
            row, place = lost[0]
            raise SimulationError(
                f"{r.source}: the model's output {r.outputs[place]} is no number from {r.time[row]:.6g} s on"
            )
