"""Any FMU as a model: its variables, and runs of it in a child process."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flexfmu.fmu_file import FmuDescription
from flexfmu.foreign.interface import Interface
from flexfmu.foreign.parent import REQUEST, RESULT, SILENCE, Child, Progress
from flexmodels.inputs import SimulationError
from flexmodels.scratch import scratch_folder

_NUMBERS = ("Real", "Float64", "Float32", "Integer", "Boolean", "Enumeration")


@dataclass(frozen=True)
class Quantity:
    """A scalar variable as its FMU describes it; minimum, maximum and start are None where it is silent."""

    name: str
    causality: str
    unit: str
    start: float | None
    minimum: float | None
    maximum: float | None
    continuous: bool
    can_be_set: bool


class FmuModel(FmuDescription):
    """An FMU that runs in a child process, over and over; use as a context manager.

    interface   None: co-simulation where the FMU has it, else model exchange
    silence     seconds without progress after which the child is stopped
    Raises SimulationError.
    """

    def __init__(self, path: str | Path, interface: Interface | None = None, silence: float = SILENCE):
        super().__init__(path)
        self._path, self._silence = Path(path), silence
        have = {
            name: description
            for name, description in (
                ("CoSimulation", self.description.coSimulation),
                ("ModelExchange", self.description.modelExchange),
            )
            if description is not None
        }
        if interface is None and not have:
            raise SimulationError(f"{path} has neither co-simulation nor model exchange")
        self.interface = interface or next(iter(have))
        if self.interface not in have:
            raise SimulationError(f"{path} has no {self.interface}; it has {' and '.join(have)}")
        listed = (v for v in self.description.modelVariables if not v.dimensions)
        self.quantities = {v.name: _quantity(v) for v in listed if _is_number(str(v.type))}

    def __enter__(self) -> "FmuModel":
        self._scratch = scratch_folder()
        self._folder = self._scratch.__enter__()
        self._child = Child(self._path, self._folder, self._silence)
        return self

    def __exit__(self, *_: object) -> None:
        self._child.__exit__()
        self._scratch.__exit__(None, None, None)

    @property
    def title(self) -> str:
        """The model's own name."""
        return self.description.modelName or self._path.stem

    def of(self, causality: str) -> list[str]:
        """Names of the variables of a causality (input, output, parameter, local)."""
        return [q.name for q in self.quantities.values() if q.causality == causality]

    def run(
        self,
        time: np.ndarray,
        inputs: Mapping[str, np.ndarray],
        sets: Sequence[Mapping[str, float]],
        outputs: Sequence[str],
        progress: Progress | None = None,
    ) -> np.ndarray:
        """Outputs of a run per set of start values, (runs, N, outputs).

        time     (N,) [s], evenly spaced
        inputs   name -> (N,)
        Raises SimulationError.
        """
        columns = np.column_stack([*inputs.values()]) if inputs else np.empty((len(time), 0))
        np.savez(self._folder / REQUEST, time=time, inputs=columns)
        request = {
            "interface": self.interface,
            "inputs": list(inputs),
            "outputs": list(outputs),
            "sets": [dict(values) for values in sets],
        }
        self._child.ask("signals", request, progress)
        return np.load(self._folder / RESULT, allow_pickle=False)


def _is_number(kind: str) -> bool:
    return kind in _NUMBERS or kind.startswith(("Int", "UInt"))


def _quantity(variable) -> Quantity:
    exact = variable.initial in ("exact", "approx") or variable.causality in ("input", "parameter")
    unit = variable.unit or (variable.declaredType.unit if variable.declaredType else None)
    return Quantity(
        name=variable.name,
        causality=variable.causality,
        unit=unit or "1",
        start=_number(variable.start),
        minimum=_number(variable.min),
        maximum=_number(variable.max),
        continuous=variable.type in ("Real", "Float64", "Float32"),
        can_be_set=exact
        and variable.variability != "constant"
        and variable.causality != "calculatedParameter",
    )


def _number(word: str | None) -> float | None:
    words = {"true": 1.0, "false": 0.0}
    try:
        return None if word is None else words[word] if word in words else float(word)
    except ValueError:
        return None
