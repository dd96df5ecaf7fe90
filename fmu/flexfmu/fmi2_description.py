"""modelDescription.xml of FMI 2.0."""

from datetime import UTC, datetime
from xml.etree import ElementTree as ET

from flexfmu.variables import TYPES, Variable, base_units, identifier, states, variables
from flexmodels.plant import Equations


def model_description(equations: Equations, token: str, sources: list[str], derivatives: bool) -> bytes:
    """The XML file; `derivatives`: whether the binary provides directional derivatives."""
    listed = variables(equations)
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=equations.name,
        guid=token,
        description=equations.description or f"Robot {equations.name} with its controller",
        generationTool="flexident",
        generationDateAndTime=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        variableNamingConvention="structured",
        numberOfEventIndicators=str(equations.joints),
    )
    common = {
        "modelIdentifier": identifier(equations),
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "providesDirectionalDerivative": str(derivatives).lower(),
    }
    exchange = ET.SubElement(root, "ModelExchange", common | {"completedIntegratorStepNotNeeded": "true"})
    simulation = ET.SubElement(
        root,
        "CoSimulation",
        common
        | {
            "canHandleVariableCommunicationStepSize": "true",
            "canInterpolateInputs": "true",
            "maxOutputDerivativeOrder": "1",
        },
    )
    for element in (exchange, simulation):
        files = ET.SubElement(element, "SourceFiles")
        for name in sources:
            ET.SubElement(files, "File", name=name)
    units = sorted({v.unit for v in listed})
    unit_definitions(root, units)
    types = ET.SubElement(root, "TypeDefinitions")
    for unit in units:
        if unit in TYPES:
            simple = ET.SubElement(types, "SimpleType", name=TYPES[unit])
            ET.SubElement(simple, "Real", quantity=TYPES[unit], unit=unit)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError", description="What was refused, and why")
    period = repr(equations.controller.period)
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime="10", stepSize=period)
    _model_variables(root, listed)
    _model_structure(root, listed, states(equations))
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def unit_definitions(root: ET.Element, units: list[str]) -> None:
    """UnitDefinitions, the same in FMI 2.0 and 3.0."""
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in units:
        unit = ET.SubElement(definitions, "Unit", name=name)
        ET.SubElement(unit, "BaseUnit", {base: str(power) for base, power in base_units(name).items()})
        if name == "rad":
            ET.SubElement(unit, "DisplayUnit", name="deg", factor=repr(57.29577951308232))


def _model_variables(root: ET.Element, listed: list[Variable]) -> None:
    element = ET.SubElement(root, "ModelVariables")
    index = {v.name: i + 1 for i, v in enumerate(listed)}
    for reference, v in enumerate(listed):
        scalar = ET.SubElement(
            element,
            "ScalarVariable",
            name=v.name,
            valueReference=str(reference),
            description=v.description,
            causality=v.causality,
            variability=v.variability,
        )
        if v.initial:
            scalar.set("initial", v.initial)
        real = ET.SubElement(scalar, "Real", numbers(v))
        if v.derivative_of:
            real.set("derivative", str(index[v.derivative_of]))


def numbers(v: Variable) -> dict[str, str]:
    """Attributes of a variable's numbers, the same in FMI 2.0 and 3.0."""
    out = {"declaredType": TYPES[v.unit]} if v.unit in TYPES else {"unit": v.unit}
    if v.unit == "rad":
        out["displayUnit"] = "deg"
    if v.minimum is not None:
        out["min"] = repr(v.minimum)
    if v.nominal is not None:
        out["nominal"] = repr(v.nominal)
    if v.start is not None:
        out["start"] = repr(float(v.start))
    return out


def _model_structure(root: ET.Element, listed: list[Variable], state_names: tuple[str, ...]) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    index = {v.name: i + 1 for i, v in enumerate(listed)}
    outputs = [v for v in listed if v.causality == "output"]
    rates = [v for v in listed if v.derivative_of]
    for section, members in (("Outputs", outputs), ("Derivatives", rates)):
        element = ET.SubElement(structure, section)
        for v in members:
            unknown = ET.SubElement(element, "Unknown", index=str(index[v.name]))
            depends = state_names if v.depends_on is None else v.depends_on
            unknown.set("dependencies", " ".join(str(i) for i in sorted(index[name] for name in depends)))
    initial = ET.SubElement(structure, "InitialUnknowns")
    names = {v.name for v in outputs} | {v.name for v in rates} | set(state_names)
    for i in sorted(index[name] for name in names):
        ET.SubElement(initial, "Unknown", index=str(i))
