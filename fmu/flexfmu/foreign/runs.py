"""Any FMU under given inputs: FMI 2.0 and 3.0, co-simulation and model exchange; runs in the child process.

In co-simulation the inputs of a sample are set, then the outputs are read, then the step is made with the
inputs held: FMPy's own loop reads first, so that what follows the inputs directly would be a sample late.
In model exchange FMPy's CVode integrates, with inputs that are linear between samples.
"""

import ctypes
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model
from fmpy.model_description import ScalarVariable

from flexfmu.fmu_file import continuous_states
from flexfmu.foreign.access import Access, feed_at_every_instant, linear_feed
from flexfmu.foreign.interface import Interface
from flexfmu.foreign.parent import REQUEST, RESULT
from flexfmu.foreign.sensitivities import Course, Structure, sensitivities, start_slopes
from flexmodels.inputs import SimulationError

_TOLERANCE = 1e-8  # of CVode
_SAME = 1e-9  # [s] two instants are one
_DOUBLES = ctypes.POINTER(ctypes.c_double)
_CALLED = 256  # samples between two signs of progress


def run(folder: Path, request: Mapping[str, Any], progress: Callable[[float], None]) -> list[str]:
    """The runs of a request: a set of start values each, all under the same inputs; their outputs."""
    fmu = _Unpacked(folder, request)
    with np.load(folder / REQUEST) as arrays:
        time, inputs = arrays["time"], arrays["inputs"]
    sets, outputs = request["sets"], request["outputs"]
    rows = np.empty((len(sets), len(time), len(outputs)))
    for i, values in enumerate(sets):

        def share(part: float, first: int = i) -> None:
            progress((first + part) / len(sets))

        simulate = fmu.exchanged if request["interface"] == "ModelExchange" else fmu.stepped
        try:
            rows[i] = simulate(time, inputs, values, share)
        except SimulationError:
            if fmu.talks:
                raise
            fmu.talks = True  # once more: some say why only where all that they say is asked for
            rows[i] = simulate(time, inputs, values, share)
    np.save(folder / RESULT, rows)
    return outputs


def slopes(folder: Path, request: Mapping[str, Any], progress: Callable[[float], None]) -> list[str]:
    """How the outputs of one run in model exchange change with some parameters; (parameters, N, outputs)."""
    fmu = _Unpacked(folder, request)
    with np.load(folder / REQUEST) as arrays:
        time, inputs = arrays["time"], arrays["inputs"]
    values, steps = request["values"], request["steps"]
    structure = fmu.structure(list(steps))

    def states_of(changed: Mapping[str, float]) -> np.ndarray:
        with fmu.begun(time, inputs, changed) as (instance, _):
            states = np.empty(len(structure.states))
            instance.getContinuousStates(states.ctypes.data_as(_DOUBLES), len(states))
        return states

    start = start_slopes(states_of, values, steps)
    with fmu.begun(time, inputs, values) as (instance, feed):
        np.save(folder / RESULT, sensitivities(instance, structure, Course(time, feed), start, progress))
    return request["outputs"]


class _Unpacked:
    """An FMU in the scratch folder, unpacked at the first request; talks: asked to say all that it can."""

    talks = False

    def __init__(self, folder: Path, request: Mapping[str, Any]):
        self.folder = folder / "fmu"
        if not self.folder.is_dir():
            extract(request["fmu"], unzipdir=str(self.folder))
        self.description = read_model_description(str(self.folder), validate=False)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.inputs, self.outputs = request["inputs"], request["outputs"]

    def stepped(
        self,
        time: np.ndarray,
        inputs: np.ndarray,
        values: Mapping[str, float],
        share: Callable[[float], None],
    ) -> np.ndarray:
        """Co-simulation, a step per sample; (N, outputs)."""
        with self._instance("CoSimulation", time[0]) as fmu:
            write = Access(fmu, "set", [self.variables[name] for name in self.inputs])
            read = Access(fmu, "get", [self.variables[name] for name in self.outputs])
            self._initialise(fmu, time, values, lambda _: write.put(inputs[0]))
            rows = np.empty((len(time), len(self.outputs)))
            for i, t in enumerate(time):
                self._now = float(t)
                write.put(inputs[i])
                rows[i] = read.values()
                if i + 1 < len(time):
                    fmu.doStep(float(t), float(time[i + 1] - t))
                if i % _CALLED == 0:
                    share(i / len(time))
            fmu.terminate()
        return rows

    def exchanged(
        self,
        time: np.ndarray,
        inputs: np.ndarray,
        values: Mapping[str, float],
        share: Callable[[float], None],
    ) -> np.ndarray:
        """Model exchange under CVode; (N, outputs), at an event what is there after it."""
        signals = np.zeros(len(time), dtype=[("time", float), *((name, float) for name in self.inputs)])
        signals["time"] = time
        for name, column in zip(self.inputs, inputs.T, strict=True):
            signals[name] = column
        start, stop = float(time[0]), float(time[-1])

        def done(now: float, _: Any) -> bool:
            self._now = now
            share((now - start) / (stop - start))
            return True

        with self._instance("ModelExchange", start) as fmu:
            feed_at_every_instant(fmu, self._feed(fmu, time, inputs))
            result = simulate_fmu(
                str(self.folder),
                validate=False,
                fmi_type="ModelExchange",
                fmu_instance=fmu,
                start_time=start,
                stop_time=stop,
                output_interval=float(time[1] - time[0]),
                relative_tolerance=_TOLERANCE,
                start_values={name: self._typed(name, value) for name, value in values.items()},
                input=signals if self.inputs else None,  # pyright: ignore[reportArgumentType]
                output=list(self.outputs),
                model_description=self.description,
                step_finished=done,
            )
        last = np.searchsorted(result["time"], time + _SAME) - 1
        return np.column_stack([np.asarray(result[name][last], dtype=float) for name in self.outputs])

    def structure(self, parameters: Sequence[str]) -> Structure:
        pairs = continuous_states(self.description)
        states = tuple(state.valueReference for state, _ in pairs)
        own = (self.variables[name].valueReference for name in parameters)
        return Structure(
            states,
            tuple(rate.valueReference for _, rate in pairs),
            tuple(self.variables[name].valueReference for name in self.outputs),
            tuple(None if vr in states else vr for vr in own),
            self.description.numberOfEventIndicators,
        )

    @contextmanager
    def begun(
        self, time: np.ndarray, inputs: np.ndarray, values: Mapping[str, float]
    ) -> "Iterator[tuple[FMU2Model | FMU3Model, Callable[[float], None]]]":
        """The FMU in Continuous-Time Mode at the first instant, and what sets its inputs at any."""
        with self._instance("ModelExchange", time[0]) as fmu:
            feed = self._feed(fmu, time, inputs)
            self._initialise(fmu, time, values, feed)
            needed = True
            while needed:
                update = fmu.newDiscreteStates if isinstance(fmu, FMU2Model) else fmu.updateDiscreteStates
                needed, ended, _, _, scheduled, event = update()
                if ended or (scheduled and event <= time[-1]):
                    raise SimulationError("the FMU has an event that is known beforehand")
            fmu.enterContinuousTimeMode()
            yield fmu, feed

    def _feed(self, fmu: Any, time: np.ndarray, inputs: np.ndarray) -> Callable[[float], None]:
        """What sets the continuous inputs, linear between samples, at an instant."""
        return linear_feed(fmu, [self.variables[name] for name in self.inputs], time, inputs)

    @property
    def _old(self) -> bool:
        return self.description.fmiVersion == "2.0"

    @contextmanager
    def _instance(self, interface: Interface, begin: float) -> "Iterator[Any]":
        """An instance, freed at the end; where it fails, its own last words and the time [s] are told."""
        messages: list[str] = []
        self._now, fmu = float(begin), None
        try:
            fmu = instantiate_fmu(
                str(self.folder), self.description, interface, debug_logging=self.talks,
                logger=lambda *words: messages.append(words[-1].decode("utf-8", "replace")),
            )  # fmt: skip
            yield fmu
        except SimulationError:
            raise
        except Exception as error:
            said = f": {messages[-1]}" if messages else ""
            raise SimulationError(f"{str(error).rstrip('.')}, at {self._now:.6g} s{said}") from None
        finally:
            if fmu is not None:
                fmu.freeInstance()

    def _initialise(
        self, fmu: Any, time: np.ndarray, values: Mapping[str, float], feed: Callable[[float], None]
    ) -> None:
        """values: of parameters and start values, and of inputs that no column feeds, which keep them."""
        early = {name: v for name, v in values.items() if not _is_input(self.variables[name])}
        kept = [name for name in values if name not in early]
        start = Access(fmu, "set", [self.variables[name] for name in early])
        held = Access(fmu, "set", [self.variables[name] for name in kept])
        span = {"startTime": float(time[0]), "stopTime": float(time[-1])}
        if self._old:
            fmu.setupExperiment(**span)
        start.put(list(early.values()))
        fmu.enterInitializationMode(**({} if self._old else span))
        held.put([values[name] for name in kept])
        feed(float(time[0]))
        fmu.exitInitializationMode()

    def _typed(self, name: str, value: float) -> float | int | bool:
        kind = self.variables[name].type
        return (
            value
            if kind in ("Real", "Float64", "Float32")
            else bool(value)
            if kind == "Boolean"
            else round(value)
        )


def _is_input(variable: ScalarVariable) -> bool:
    return variable.causality == "input"
