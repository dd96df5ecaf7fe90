"""Many runs of one experiment: a parameter set and a noise seed each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
import pandas as pd

from flexfmu.batch import BatchBinary
from flexfmu.fed import input_values, start_values
from flexfmu.names import fmi_name
from flexmodels.inputs import Experiment, SimulationError

T = TypeVar("T")
Progress = Callable[[float], None]
_LARGEST = 2**27  # bytes of rows of one call


class Simulates(Protocol):
    """What is needed of a loaded FMU."""

    @property
    def references(self) -> Mapping[str, int]: ...
    @property
    def logged(self) -> tuple[str, ...]: ...
    @property
    def library(self) -> Path | None: ...
    def simulate(self, experiment: Experiment, parameters: Mapping[str, float]) -> pd.DataFrame: ...


def run_replicas(
    fmu: Simulates,
    experiment: Experiment,
    parameters: Sequence[Mapping[str, float]],
    noise: Mapping[str, float],
    seeds: Sequence[int | None],
    progress: Progress | None,
) -> list[pd.DataFrame]:
    """A frame per run; see LoadedFmu.simulate_batch."""
    runs = max(len(parameters), len(seeds))
    if {len(parameters), len(seeds)} - {1, runs}:
        raise SimulationError(f"{len(parameters)} parameter sets and {len(seeds)} noise seeds do not match")
    sets = [start_values(fmu.references, experiment) | dict(p) for p in _repeated(parameters, runs)]
    drawn = [_drawn(noise, seed, len(experiment.time)) for seed in _repeated(seeds, runs)]
    binary = _binary(fmu.library)
    if binary is None:
        return [_alone(fmu, experiment, p, added) for p, added in zip(sets, drawn, strict=True)]
    with binary:
        return _together(fmu, binary, experiment, sets, drawn, progress)


def _repeated(values: Sequence[T], runs: int) -> Sequence[T]:
    return values if len(values) == runs else [*values] * runs


def _drawn(noise: Mapping[str, float], seed: int | None, samples: int) -> dict[str, np.ndarray]:
    """Coordinate -> its sensor's white noise; none without a seed."""
    if seed is None:
        return {}
    rng = np.random.default_rng(seed)
    return {name: sigma * rng.standard_normal(samples) for name, sigma in noise.items()}


def _binary(library: Path | None) -> BatchBinary | None:
    try:
        return BatchBinary(library) if library else None
    except (OSError, AttributeError):  # another tool's FMU
        return None


def _sensed(experiment: Experiment, added: Mapping[str, np.ndarray]) -> np.ndarray:
    """(samples, joints): what the controller's sensors add."""
    samples, joints = experiment.reference.shape
    return np.column_stack([added.get(f"joint{k}.e", np.zeros(samples)) for k in range(1, joints + 1)])


def _alone(
    fmu: Simulates, experiment: Experiment, parameters: Mapping[str, float], added: Mapping[str, np.ndarray]
) -> pd.DataFrame:
    """By the references: a PID of r − (e + noise) is one of (r − noise) − e."""
    seen = _sensed(experiment, added)
    frame = fmu.simulate(replace(experiment, reference=experiment.reference - seen), parameters)
    for k, r in enumerate(experiment.reference.T, start=1):
        frame[f"joint{k}.r"] = r
    for name, values in added.items():
        frame[name] = frame[name] + values
    return frame


def _together(
    fmu: Simulates,
    binary: BatchBinary,
    experiment: Experiment,
    sets: list[dict[str, float]],
    drawn: list[dict[str, np.ndarray]],
    progress: Progress | None,
) -> list[pd.DataFrame]:
    joints = experiment.reference.shape[1]
    if joints != binary.joints:
        raise SimulationError(f"the FMU has {binary.joints} joints, the experiment {joints}")
    inputs = input_values(fmu.references, experiment)
    names = sorted({name for p in sets for name in p})
    incomplete = [name for name in names if any(name not in p for p in sets)]
    if incomplete:
        raise SimulationError(f"every parameter set must give a value of {incomplete[0]}, or none")
    unknown = sorted({fmi_name(n) for n in names} - set(fmu.references))
    if unknown:
        raise SimulationError(f"the FMU has no variable {unknown[0]}")
    columns = fmu.logged
    share = max(binary.width, _LARGEST // (8 * len(columns) * len(experiment.time)))
    frames: list[pd.DataFrame] = []
    for first in range(0, len(sets), share):
        part = slice(first, first + share)
        values = np.array([[p[name] for name in names] for p in sets[part]]).reshape(len(sets[part]), -1)
        sensed = np.stack([_sensed(experiment, added) for added in drawn[part]])
        rows, finite = binary.run(
            experiment.time,
            inputs,
            [fmu.references[fmi_name(name)] for name in names],
            values,
            sensed if any(drawn[part]) else None,
            [fmu.references[name] for name in columns],
            _part_of(progress, first, len(values), len(sets)),
        )
        if not finite.all():
            number = first + int(np.argmin(finite))
            raise SimulationError(
                f"run {number}: the state left the finite numbers: reduce solver.step or check the parameters"
            )
        frames += [_frame(experiment, columns, r, a) for r, a in zip(rows, drawn[part], strict=True)]
    return frames


def _part_of(progress: Progress | None, first: int, runs: int, total: int) -> Progress | None:
    return (lambda done: progress((first + done * runs) / total)) if progress else None


def _frame(
    experiment: Experiment, columns: tuple[str, ...], rows: np.ndarray, added: Mapping[str, np.ndarray]
) -> pd.DataFrame:
    frame = pd.DataFrame(rows, columns=list(columns))
    frame.insert(0, "time", experiment.time)
    for name, values in added.items():
        frame[name] = frame[name] + values
    return frame
