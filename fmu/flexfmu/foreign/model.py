"""Any FMU as a model: its variables, and runs of it in a child process."""

import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from flexfmu.fmu_file import FmuDescription, continuous_states, require_binary
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
        super().__init__(path, lenient=True)
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
        require_binary(self._path)
        self._variables = {v.name: v for v in self.description.modelVariables}
        self._gives_derivatives = self.interface == "ModelExchange" and _gives_derivatives(self._path)
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
        request = {"interface": self.interface, "sets": [dict(values) for values in sets]}
        return self._asked("signals", time, inputs, outputs, request, progress)

    def sensitivities(
        self,
        time: np.ndarray,
        inputs: Mapping[str, np.ndarray],
        values: Mapping[str, float],
        steps: Mapping[str, float],
        outputs: Sequence[str],
        progress: Progress | None = None,
    ) -> np.ndarray:
        """Derivatives of the outputs by parameters, (parameters, N, outputs), by directional derivatives.

        values   of the run;  steps   parameter of `has_sensitivity` -> what a small change of it is
        Raises SimulationError, also where the FMU has an event: what jumps there has no such derivative.
        """
        request = {"values": dict(values), "steps": dict(steps)}
        return self._asked("slopes", time, inputs, outputs, request, progress)

    def has_sensitivity(self, name: str, inputs: Sequence[str], outputs: Sequence[str]) -> bool:
        """Whether the standard gives the outputs' derivatives by a variable: in model exchange, of listed
        outputs and states by tunable parameters and the start of states, under continuous inputs."""
        pairs = continuous_states(self.description)
        if not self._gives_derivatives or not pairs or any(rate.dimensions for _, rate in pairs):
            return False
        states = {state.valueReference for state, _ in pairs}
        listed = states | {u.variable.valueReference for u in self.description.outputs if u.variable}
        variable = self._variables[name]
        tunable = variable.causality == "parameter" and variable.variability == "tunable"
        return (
            (tunable or variable.valueReference in states)
            and all(self._variables[o].valueReference in listed for o in outputs)
            and all(self._variables[i].variability in (None, "continuous") for i in inputs)
        )

    def _asked(
        self,
        job: str,
        time: np.ndarray,
        inputs: Mapping[str, np.ndarray],
        outputs: Sequence[str],
        request: Mapping[str, object],
        progress: Progress | None,
    ) -> np.ndarray:
        columns = np.column_stack([*inputs.values()]) if inputs else np.empty((len(time), 0))
        np.savez(self._folder / REQUEST, time=time, inputs=columns)
        request = {"inputs": list(inputs), "outputs": list(outputs), **request}
        self._child.ask(job, request, progress)
        return np.load(self._folder / RESULT, allow_pickle=False)


def _gives_derivatives(path: Path) -> bool:
    """Of model exchange; read here since FMPy does not know FMI 3's word, which is in the plural."""
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    exchange = root.find("ModelExchange")
    words = ("providesDirectionalDerivative", "providesDirectionalDerivatives")
    return exchange is not None and any(exchange.get(word) in ("true", "1") for word in words)


def _is_number(kind: str) -> bool:
    return kind in _NUMBERS or kind.startswith(("Int", "UInt"))


def _quantity(variable) -> Quantity:
    exact = variable.initial in ("exact", "approx") or variable.causality in ("input", "parameter")

    def own(word: str) -> str | None:
        """What the variable says itself, else its type."""
        said = getattr(variable, word)
        return getattr(variable.declaredType, word) if said is None and variable.declaredType else said

    return Quantity(
        name=variable.name,
        causality=variable.causality,
        unit=own("unit") or "1",
        start=_number(variable.start),
        minimum=_number(own("min")),
        maximum=_number(own("max")),
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
