"""Any FMU under given inputs: FMI 2.0 and 3.0, co-simulation and model exchange; runs in the child process.

In co-simulation the inputs of a sample are set, then the outputs are read, then the step is made with the
inputs held: FMPy's own loop reads first, so that what follows the inputs directly would be a sample late.
In model exchange FMPy's CVode integrates, with inputs that are linear between samples.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.model_description import ScalarVariable

from flexfmu.foreign.parent import REQUEST, RESULT

_TOLERANCE = 1e-8  # of CVode
_SAME = 1e-9  # [s] two instants are one
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
        rows[i] = simulate(time, inputs, values, share)
    np.save(folder / RESULT, rows)
    return outputs


class _Unpacked:
    """An FMU in the scratch folder, unpacked at the first request."""

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
        fmu = self._slave()
        write = _Access(fmu, "set", [self.variables[name] for name in self.inputs])
        read = _Access(fmu, "get", [self.variables[name] for name in self.outputs])
        early = {name: v for name, v in values.items() if not _is_input(self.variables[name])}
        try:
            start = _Access(fmu, "set", [self.variables[name] for name in early])
            if isinstance(fmu, FMU2Slave):
                fmu.setupExperiment(startTime=float(time[0]), stopTime=float(time[-1]))
                start.put(list(early.values()))
                fmu.enterInitializationMode()
            else:
                start.put(list(early.values()))
                fmu.enterInitializationMode(startTime=float(time[0]), stopTime=float(time[-1]))
            write.put(inputs[0])
            fmu.exitInitializationMode()
            rows = np.empty((len(time), len(self.outputs)))
            for i, t in enumerate(time):
                write.put(inputs[i])
                rows[i] = read.values()
                if i + 1 < len(time):
                    fmu.doStep(float(t), float(time[i + 1] - t))
                if i % _CALLED == 0:
                    share(i / len(time))
            fmu.terminate()
        finally:
            fmu.freeInstance()
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
        stop = float(time[-1])
        result = simulate_fmu(
            str(self.folder),
            validate=False,
            fmi_type="ModelExchange",
            start_time=float(time[0]),
            stop_time=stop,
            output_interval=float(time[1] - time[0]),
            relative_tolerance=_TOLERANCE,
            start_values={name: self._typed(name, value) for name, value in values.items()},
            input=signals if self.inputs else None,  # pyright: ignore[reportArgumentType]
            output=list(self.outputs),
            model_description=self.description,
            step_finished=lambda now, _: share(now / stop) or True,
        )
        last = np.searchsorted(result["time"], time + _SAME) - 1
        return np.column_stack([np.asarray(result[name][last], dtype=float) for name in self.outputs])

    def _slave(self) -> "FMU2Slave | FMU3Slave":
        simulation = self.description.coSimulation
        assert simulation is not None
        kind = FMU2Slave if self.description.fmiVersion == "2.0" else FMU3Slave
        fmu = kind(
            guid=self.description.guid,
            unzipDirectory=str(self.folder),
            modelIdentifier=simulation.modelIdentifier,
            instanceName="model",
        )
        fmu.instantiate()
        return fmu

    def _typed(self, name: str, value: float) -> float | int | bool:
        kind = self.variables[name].type
        return (
            value
            if kind in ("Real", "Float64", "Float32")
            else bool(value)
            if kind == "Boolean"
            else round(value)
        )


class _Access:
    """Set or get some variables of any type by as few calls as their types need."""

    def __init__(self, fmu: Any, verb: str, variables: Sequence[ScalarVariable]):
        calls: dict[str, list[int]] = {}
        for place, variable in enumerate(variables):
            kind = str(variable.type)
            if kind == "Enumeration":
                kind = "Integer" if isinstance(fmu, FMU2Slave) else "Int64"
            calls.setdefault(kind, []).append(place)
        self._size = len(variables)
        self._calls = [
            (getattr(fmu, verb + kind), kind, places, [variables[p].valueReference for p in places])
            for kind, places in calls.items()
        ]

    def put(self, values: Sequence[float] | np.ndarray) -> None:
        for call, kind, places, references in self._calls:
            listed = [float(values[p]) for p in places]
            whole = kind not in ("Real", "Float64", "Float32")
            call(
                references, [bool(v) if kind == "Boolean" else round(v) for v in listed] if whole else listed
            )

    def values(self) -> np.ndarray:
        row = np.empty(self._size)
        for call, _, places, references in self._calls:
            row[places] = call(references)
        return row


def _is_input(variable: ScalarVariable) -> bool:
    return variable.causality == "input"
