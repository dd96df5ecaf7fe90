"""The FMU's variables and its modelDescription.xml (FMI 2.0)."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from xml.etree import ElementTree as ET

from flexmodels.plant import Equations

STEP = 0.5e-3  # default solver step [s]
INPUTS = ("r", "tau_ff")
_AXES = {"x": "1", "y": "2", "z": "3"}
_NEWTON = {"kg": 1, "m": 1, "s": -2}


@dataclass(frozen=True)
class Variable:
    """One FMI variable; its place in the list of `variables` is its value reference."""

    name: str
    causality: str
    variability: str
    unit: str
    description: str
    start: float | None = None
    minimum: float | None = None


def variables(equations: Equations) -> list[Variable]:
    """Every variable in the order of the C enum in runtime/plant.h."""
    return [*_inputs(equations), *_states(equations), *_results(equations), *_parameters(equations)]


def fmi_name(parameter: str) -> str:
    """FMI's structured name of a parameter: link1.ms[x] -> link1.ms[1], link1.J[xy] -> link1.J[1,2]."""
    return re.sub(r"\[([xyz]+)\]", lambda m: f"[{','.join(_AXES[a] for a in m[1])}]", parameter)


def model_description(equations: Equations, token: str, sources: list[str]) -> bytes:
    """modelDescription.xml of the co-simulation FMU."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=equations.name,
        guid=token,
        description=equations.description or f"Robot {equations.name} with its controller",
        generationTool="flexident",
        generationDateAndTime=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    simulation = ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=identifier(equations),
        canHandleVariableCommunicationStepSize="true",
        canInterpolateInputs="true",
        maxOutputDerivativeOrder="0",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="false",
    )
    files = ET.SubElement(simulation, "SourceFiles")
    for name in sources:
        ET.SubElement(files, "File", name=name)
    listed = variables(equations)
    _unit_definitions(root, sorted({v.unit for v in listed}))
    ET.SubElement(
        root, "DefaultExperiment", startTime="0", stopTime="10", stepSize=repr(equations.controller.period)
    )
    _model_variables(root, listed)
    _model_structure(root, listed)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def base_units(unit: str) -> dict[str, int]:
    """Powers of the SI base units (and rad) in a unit such as `N.m/(rad.s)` or `kg.m2`."""
    powers: dict[str, int] = {}
    for side, text in zip((1, -1), unit.replace("(", "").replace(")", "").split("/"), strict=False):
        for symbol, exponent in re.findall(r"([A-Za-z]+)(\d*)", text):
            for base, power in (_NEWTON if symbol == "N" else {symbol: 1}).items():
                powers[base] = powers.get(base, 0) + side * power * int(exponent or 1)
    return {base: power for base, power in powers.items() if power}


def identifier(equations: Equations) -> str:
    """The C identifier that names the binary."""
    return re.sub(r"\W", "_", equations.name)


def _motion_unit(equations: Equations, joint: int) -> str:
    return "m" if equations.prismatic[joint] else "rad"


def _force_unit(equations: Equations, joint: int) -> str:
    return "N" if equations.prismatic[joint] else "N.m"


def _inputs(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Reference of joint {k + 1}, read at every sample of the controller"
        yield Variable(f"joint{k + 1}.r", "input", "continuous", _motion_unit(eq, k), text, 0.0)
    for k in range(eq.joints):
        text = f"Feed-forward torque added to the controller's output at joint {k + 1}"
        yield Variable(f"joint{k + 1}.tau_ff", "input", "continuous", _force_unit(eq, k), text, 0.0)


def _states(eq: Equations) -> Iterator[Variable]:
    for name in eq.coordinates:
        k = int(re.findall(r"\d+", name)[0]) - 1
        unit = "rad" if "eps" in name else _motion_unit(eq, k)
        text = "deformation of the flexible hinge" if "eps" in name else "position of the motor hinge"
        yield Variable(name, "output", "continuous", unit, f"Joint {k + 1}: {text}")
    for name in eq.coordinates:
        k = int(re.findall(r"\d+", name)[0]) - 1
        unit = "rad" if "eps" in name else _motion_unit(eq, k)
        rate = name.replace(".e", ".de", 1)
        yield Variable(rate, "local", "continuous", f"{unit}/s", f"Rate of {name}")


def _results(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Motor torque of joint {k + 1}, held until the next sample"
        yield Variable(f"joint{k + 1}.tau", "output", "discrete", _force_unit(eq, k), text)
    for axis in "xyz":
        yield Variable(f"tip.{axis}", "output", "continuous", "m", f"Tip position, base axis {axis}")
    for k in range(eq.joints):
        text = f"Torque that the laws at motor hinge {k + 1} take, the reaction of a stuck hinge included"
        yield Variable(f"joint{k + 1}.friction", "local", "continuous", _force_unit(eq, k), text)


def _parameters(eq: Equations) -> Iterator[Variable]:
    for name, value in eq.parameters.items():
        minimum = 0.0 if name in eq.nonnegative else None
        yield Variable(fmi_name(name), "parameter", "tunable", eq.units[name], name, value, minimum)
    gains = {
        "Kp": ("Proportional", eq.controller.Kp, "N.m/rad", "N/m"),
        "Kd": ("Derivative", eq.controller.Kd, "N.m.s/rad", "N.s/m"),
        "Ki": ("Integral", eq.controller.Ki, "N.m/(rad.s)", "N/(m.s)"),
    }
    for gain, (word, values, hinge, slider) in gains.items():
        for k, value in enumerate(values):
            unit = slider if eq.prismatic[k] else hinge
            yield Variable(f"joint{k + 1}.{gain}", "parameter", "tunable", unit, f"{word} gain", value)
    yield Variable("solver.step", "parameter", "tunable", "s", "Largest step of the solver", STEP)


def _unit_definitions(root: ET.Element, units: list[str]) -> None:
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in units:
        unit = ET.SubElement(definitions, "Unit", name=name)
        ET.SubElement(unit, "BaseUnit", {base: str(power) for base, power in base_units(name).items()})


def _model_variables(root: ET.Element, listed: list[Variable]) -> None:
    element = ET.SubElement(root, "ModelVariables")
    for reference, v in enumerate(listed):
        initial = "exact" if v.causality == "parameter" else None if v.causality == "input" else "calculated"
        scalar = ET.SubElement(
            element,
            "ScalarVariable",
            name=v.name,
            valueReference=str(reference),
            description=v.description,
            causality=v.causality,
            variability=v.variability,
        )
        if initial:
            scalar.set("initial", initial)
        real = ET.SubElement(scalar, "Real", unit=v.unit)
        if v.minimum is not None:
            real.set("min", repr(v.minimum))
        if v.start is not None:
            real.set("start", repr(float(v.start)))


def _model_structure(root: ET.Element, listed: list[Variable]) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [str(i + 1) for i, v in enumerate(listed) if v.causality == "output"]
    for section in ("Outputs", "InitialUnknowns"):
        element = ET.SubElement(structure, section)
        for index in outputs:
            ET.SubElement(element, "Unknown", index=index)
