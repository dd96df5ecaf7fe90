"""FMU + experiment -> log, for FMUs that follow the log contract."""

import ctypes
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
from fmpy import calloc, extract, free, simulate_fmu
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

from flexfmu.batch.replicas import Look, run_replicas
from flexfmu.code.compilation import HOST
from flexfmu.fed import input_names, input_values, start_values
from flexfmu.finite import require_finite
from flexfmu.fmu_file import FmuDescription, first_line
from flexfmu.foreign.by_fmpy import Course, run_by_fmpy
from flexfmu.names import fmi_name
from flexmodels.inputs import Experiment, SimulationError
from flexmodels.scratch import scratch_folder

Progress = Callable[[float], None]
_LOGGED = re.compile(r"joint\d+\.(r|tau_ff|on|e|eps\[\d\]|tau)|tip\.[xyz]")


class LoadedFmu(FmuDescription):
    """An unpacked FMU that can be simulated many times; use as a context manager.

    Its variables follow the log contract: inputs joint{k}.r and joint{k}.tau_ff, outputs joint{k}.e,
    joint{k}.eps[i], joint{k}.tau and tip.x, tip.y, tip.z.
    """

    def __init__(self, path: str | Path):
        super().__init__(path)
        self._stack = ExitStack()
        self._folder = str(self._stack.enter_context(scratch_folder()))
        try:
            extract(str(path), unzipdir=self._folder)
        except Exception as error:
            self._stack.close()
            raise SimulationError(f"{path} cannot be unpacked ({first_line(error)})") from None

    def __enter__(self) -> "LoadedFmu":
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def simulate(
        self,
        experiment: Experiment,
        parameters: Mapping[str, float] | None = None,
        outputs: tuple[str, ...] = (),
        progress: Progress | None = None,
    ) -> pd.DataFrame:
        """Run the experiment; one row per sample of its time grid, columns of the log contract.

        parameters  public names (`link1.ms[x]`, `joint1.coulomb`) or FMI names, and new values
        outputs     further variables to record
        progress    called with the fraction done
        Raises SimulationError.
        """
        parameters = start_values(self.references, experiment) | dict(parameters or {})
        logged = self.logged + outputs
        self._require({*map(fmi_name, parameters), *outputs})
        plain = self.description.fmiVersion == "2.0" and self.description.coSimulation is not None
        run = self._step_by_step if plain else self._by_fmpy
        rows = run(experiment, parameters or {}, logged, progress)
        frame = pd.DataFrame(rows, columns=list(logged))
        frame.insert(0, "time", experiment.time)
        require_finite(frame)
        return frame

    def _step_by_step(
        self,
        experiment: Experiment,
        parameters: Mapping[str, float],
        logged: tuple[str, ...],
        progress: Progress | None,
    ) -> np.ndarray:
        """FMI 2.0 co-simulation, with input derivatives where the FMU takes them."""
        messages: list[str] = []
        fmu = self._instance(messages)
        try:
            return self._run(fmu, experiment, parameters, logged, progress)
        except Exception as error:
            raise SimulationError(messages[-1] if messages else f"the FMU failed ({error})") from None
        finally:
            fmu.freeInstance()

    def _by_fmpy(
        self,
        experiment: Experiment,
        parameters: Mapping[str, float],
        logged: tuple[str, ...],
        progress: Progress | None,
    ) -> np.ndarray:
        """FMI 3.0 and model exchange, by FMPy's own loop; inputs are linear between samples."""
        names, inputs = self._input_names(experiment), input_values(self.references, experiment)
        course = Course(experiment.time, tuple(names), inputs)
        starts = {fmi_name(name): value for name, value in parameters.items()}
        rows = run_by_fmpy(self._folder, self.description, course, starts, logged, progress)
        for name, values in zip(names, inputs.T, strict=True):
            rows[:, logged.index(name)] = values
        return rows

    @property
    def logged(self) -> tuple[str, ...]:
        """Columns of a log, beside the time."""
        listed = self.description.modelVariables
        return tuple(v.name for v in listed if _LOGGED.fullmatch(v.name))

    @property
    def library(self) -> Path | None:
        """The binary for this machine."""
        version = 2 if self.description.fmiVersion == "2.0" else 3
        folder = Path(self._folder) / "binaries" / HOST.folder(version)
        return next(iter(sorted(folder.glob(f"*{HOST.suffix}"))), None)

    def simulate_batch(
        self,
        experiment: Experiment | Sequence[Experiment],
        parameters: Sequence[Mapping[str, float]] = ({},),
        noise: Mapping[str, float] | None = None,
        noise_seeds: Sequence[int | None] = (None,),
        progress: Progress | None = None,
        look: Look | None = None,
    ) -> list[pd.DataFrame]:
        """Many runs, several side by side in vector registers where the FMU is ours.

        experiment   one for all runs, or one per run; those with the same times go side by side
        parameters   a set per run, all of the same names, or one for all
        noise        coordinate -> standard deviation of its sensor's white noise [rad or m]. That of a motor
                     hinge passes through the loop: the controller measures it; all of it is in the frames
        noise_seeds  a seed per run (the noise of np.random.default_rng(seed), coordinate by coordinate), or
                     one for all; None is a run without noise
        progress     called with the fraction done
        look         called now and then with the number of a run of an FMU of ours and its rows so far,
                     without the sensors' noise; what it raises ends all runs
        Returns a frame per run, as from `simulate`. Raises SimulationError.
        """
        return run_replicas(self, experiment, parameters, noise or {}, noise_seeds, progress, look)

    def _require(self, names: set[str]) -> None:
        unknown = sorted(names - set(self.references))
        if unknown:
            raise SimulationError(f"the FMU has no variable {unknown[0]}")

    def _instance(self, messages: list[str]) -> FMU2Slave:
        simulation = self.description.coSimulation
        assert simulation is not None
        fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=self._folder,
            modelIdentifier=simulation.modelIdentifier,
            instanceName="plant",
        )
        fmu.instantiate(callbacks=_callbacks(messages))
        return fmu

    def _run(
        self,
        fmu: FMU2Slave,
        experiment: Experiment,
        parameters: Mapping[str, float],
        logged: tuple[str, ...],
        progress: Progress | None,
    ) -> np.ndarray:
        time, inputs = experiment.time, input_values(self.references, experiment)
        slopes = np.diff(inputs, axis=0, append=inputs[-1:]) / np.diff(time, append=time[-1] + 1)[:, None]
        read = _vector(self.references[name] for name in logged)
        written = _vector(self.references[name] for name in self._input_names(experiment))
        order = (ctypes.c_int * len(written))(*([1] * len(written)))
        rows = np.empty((len(time), len(logged)))
        fmu.setupExperiment(startTime=time[0])
        if parameters:
            fmu.setReal([self.references[fmi_name(n)] for n in parameters], list(parameters.values()))
        fmu.enterInitializationMode()
        fmu.fmi2SetReal(fmu.component, written, len(written), _pointer(inputs[0]))
        fmu.exitInitializationMode()
        interpolates = self.description.coSimulation.canInterpolateInputs  # pyright: ignore
        value, slope, result = (np.empty(n) for n in (len(written), len(written), len(read)))
        to_value, to_slope, to_result = map(_pointer, (value, slope, result))  # made once: they take time
        component, now, steps = fmu.component, time.tolist(), np.diff(time).tolist()
        for i, step in enumerate([*steps, None]):
            value[:] = inputs[i]
            fmu.fmi2SetReal(component, written, len(written), to_value)
            fmu.fmi2GetReal(component, read, len(read), to_result)  # a sample that is due answers at once
            rows[i] = result
            if step is None:
                break
            if interpolates:
                slope[:] = slopes[i]
                fmu.fmi2SetRealInputDerivatives(component, written, len(written), order, to_slope)
            fmu.fmi2DoStep(component, now[i], step, 0)
            if progress and i % 64 == 0:
                progress(i / len(time))
        fmu.terminate()
        for j, name in enumerate(self._input_names(experiment)):
            rows[:, logged.index(name)] = inputs[:, j]
        return rows

    def _input_names(self, experiment: Experiment) -> list[str]:
        names = input_names(self.references, experiment.reference.shape[1])
        self._require(set(names))
        return names


@contextmanager
def loaded_fmu(content: bytes) -> Iterator[LoadedFmu]:
    """An FMU file's content, unpacked and ready. Raises SimulationError."""
    with scratch_folder() as folder:
        path = folder / "plant.fmu"
        path.write_bytes(content)
        with LoadedFmu(path) as fmu:
            yield fmu


def constant_run(
    fmu: str | Path, inputs: Mapping[str, float], step: float, stop: float, outputs: tuple[str, ...] = ()
) -> pd.DataFrame:
    """Co-simulation of an FMU (file or unpacked) under constant inputs; a row per step, the start first.

    outputs     variables to record, none: all outputs
    Raises SimulationError.
    """
    try:
        result = simulate_fmu(
            str(fmu),
            fmi_type="CoSimulation",
            stop_time=stop,
            output_interval=step,
            start_values=dict(inputs),
            output=list(outputs) or None,  # pyright: ignore[reportArgumentType]
        )
    except Exception as error:
        raise SimulationError(f"{fmu}: the FMU failed ({error})") from None
    return pd.DataFrame(result)


def _callbacks(messages: list[str]) -> fmi2CallbackFunctions:
    """FMI callbacks that keep the FMU's messages."""

    def keep(_environment, _instance, _status, _category, message) -> None:
        messages.append(message.decode("utf-8", "replace"))

    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(keep)
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    return callbacks


def _vector(references) -> ctypes.Array:
    listed = list(references)
    return (ctypes.c_uint * len(listed))(*listed)


def _pointer(row: np.ndarray):
    return row.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
