"""Many runs: an experiment, a parameter set and a noise seed each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
import pandas as pd

from flexfmu.batch.binary import WHY_LOST, BatchBinary
from flexfmu.batch.side_by_side import in_threads
from flexfmu.fed import input_values, start_values
from flexfmu.names import fmi_name
from flexmodels.cores import cores
from flexmodels.inputs import Experiment, SimulationError

T = TypeVar("T")
Progress = Callable[[float], None]
Look = Callable[[int, pd.DataFrame], None]
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


@dataclass(frozen=True)
class _Run:
    """number: in the order asked;  added: coordinate -> (samples,) its sensor's noise"""

    number: int
    experiment: Experiment
    parameters: dict[str, float]
    added: dict[str, np.ndarray]

    @property
    def sensed(self) -> np.ndarray:
        """(samples, joints): what the controller's sensors add."""
        samples, joints = self.experiment.reference.shape
        none = np.zeros(samples)
        return np.column_stack([self.added.get(f"joint{k}.e", none) for k in range(1, joints + 1)])


def run_replicas(
    fmu: Simulates,
    experiment: Experiment | Sequence[Experiment],
    parameters: Sequence[Mapping[str, float]],
    noise: Mapping[str, float],
    seeds: Sequence[int | None],
    progress: Progress | None,
    look: Look | None = None,
) -> list[pd.DataFrame]:
    """A frame per run; see LoadedFmu.simulate_batch. Raises SimulationError."""
    experiments = [experiment] if isinstance(experiment, Experiment) else list(experiment)
    given = {"experiments": len(experiments), "parameter sets": len(parameters), "noise seeds": len(seeds)}
    many = {what: number for what, number in given.items() if number != 1}
    if len(set(many.values())) > 1:
        listed = " and ".join(f"{number} {what}" for what, number in many.items())
        raise SimulationError(f"{listed} do not match")
    count = max(given.values()) if 0 not in given.values() else 0
    runs = [
        _Run(i, e, start_values(fmu.references, e) | dict(p), _drawn(noise, seed, len(e.time)))
        for i, e, p, seed in zip(
            range(count), *(_repeated(v, count) for v in (experiments, parameters, seeds)), strict=True
        )
    ]
    binary = _binary(fmu.library)
    if binary is None:
        return [_alone(fmu, run) for run in runs]
    frames: dict[int, pd.DataFrame] = {}
    with binary:
        for group in _same_times(runs):
            told = _part_of(progress, len(frames), len(group), count)
            made = _together(fmu, binary, group, told, look)
            frames |= {run.number: frame for run, frame in zip(group, made, strict=True)}
    return [frames[i] for i in range(count)]


def _same_times(runs: Sequence[_Run]) -> list[list[_Run]]:
    """Those that can go side by side."""
    groups: list[list[_Run]] = []
    for run in runs:
        for group in groups:
            if np.array_equal(group[0].experiment.time, run.experiment.time):
                group.append(run)
                break
        else:
            groups.append([run])
    return groups


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


def _alone(fmu: Simulates, run: _Run) -> pd.DataFrame:
    """By the references: a PID of r − (e + noise) is one of (r − noise) − e."""
    seen = run.experiment.reference - run.sensed
    frame = fmu.simulate(replace(run.experiment, reference=seen), run.parameters)
    for k, r in enumerate(run.experiment.reference.T, start=1):
        frame[f"joint{k}.r"] = r
    for name, values in run.added.items():
        frame[name] = frame[name] + values
    return frame


def _together(
    fmu: Simulates, binary: BatchBinary, runs: Sequence[_Run], progress: Progress, look: Look | None
) -> list[pd.DataFrame]:
    """Runs over the same times."""
    time, joints = runs[0].experiment.time, runs[0].experiment.reference.shape[1]
    if joints != binary.joints:
        raise SimulationError(f"the FMU has {binary.joints} joints, the experiment {joints}")
    names = sorted({name for run in runs for name in run.parameters})
    incomplete = [name for name in names if any(name not in run.parameters for run in runs)]
    if incomplete:
        raise SimulationError(f"every parameter set must give a value of {incomplete[0]}, or none")
    unknown = sorted({fmi_name(n) for n in names} - set(fmu.references))
    if unknown:
        raise SimulationError(f"the FMU has no variable {unknown[0]}")
    references = [fmu.references[fmi_name(name)] for name in names]
    columns = [fmu.references[name] for name in fmu.logged]

    def made(part: Sequence[_Run], told: Progress) -> list[pd.DataFrame]:
        experiments = list({id(run.experiment): run.experiment for run in part}.values())
        place = {id(e): i for i, e in enumerate(experiments)}
        rows, lost = binary.run(
            time,
            np.stack([input_values(fmu.references, e) for e in experiments]),
            np.array([place[id(run.experiment)] for run in part]),
            references,
            np.array([[run.parameters[name] for name in names] for run in part]).reshape(len(part), -1),
            np.stack([run.sensed for run in part]) if any(run.added for run in part) else None,
            columns,
            told,
            partial(_looked, look, part, fmu.logged) if look else None,
        )
        if lost.any():
            at = int(np.flatnonzero(lost)[0])
            raise SimulationError(f"run {part[at].number}: {WHY_LOST[int(lost[at])]}")
        return [_frame(run, fmu.logged, r) for run, r in zip(part, rows, strict=True)]

    parts = _parts(runs, binary.width, _LARGEST // (8 * len(columns) * len(time)))
    return [frame for frames in in_threads(made, parts, progress) for frame in frames]


def _looked(look: Look, part: Sequence[_Run], columns: Sequence[str], number: int, rows: np.ndarray) -> None:
    look(part[number].number, pd.DataFrame(rows, columns=list(columns)))


def _parts(runs: Sequence[_Run], width: int, most: int) -> list[Sequence[_Run]]:
    """Runs of one call each: whole vectors, and as many calls as there are cores where there are enough."""
    vectors = -(-len(runs) // width)
    size = width * max(1, min(most // width, -(-vectors // cores())))
    return [runs[first : first + size] for first in range(0, len(runs), size)]


def _part_of(progress: Progress | None, before: int, runs: int, total: int) -> Progress:
    return (lambda done: progress((before + done * runs) / total)) if progress else (lambda _: None)


def _frame(run: _Run, columns: tuple[str, ...], rows: np.ndarray) -> pd.DataFrame:
    frame = pd.DataFrame(rows, columns=list(columns))
    frame.insert(0, "time", run.experiment.time)
    for name, values in run.added.items():
        frame[name] = frame[name] + values
    return frame
