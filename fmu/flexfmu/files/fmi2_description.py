"""modelDescription.xml of FMI 2.0."""

from xml.etree import ElementTree as ET

from flexfmu.files.provenance import sign
from flexfmu.files.units import TYPES, base_units
from flexfmu.interface import Interface
from flexfmu.variable import Variable

LOG_CATEGORIES = {
    "logStatusError": "What was refused, and why; always on",
    "logEvents": "Joints that stick and slide",
}


def model_description(interface: Interface, token: str, sources: list[str], derivatives: bool) -> bytes:
    """The XML file; `derivatives`: whether the binary provides directional derivatives."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=interface.name,
        guid=token,
        description=interface.description,
        variableNamingConvention="structured",
        numberOfEventIndicators=str(interface.indicators),
    )
    sign(root)
    common = {
        "modelIdentifier": interface.identifier,
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
        "canNotUseMemoryManagementFunctions": "true",
        "providesDirectionalDerivative": str(derivatives).lower(),
    }
    elements = []
    if interface.states:
        exchange = common | {"completedIntegratorStepNotNeeded": "true"}
        elements.append(ET.SubElement(root, "ModelExchange", exchange))
    simulation = common | {
        "canHandleVariableCommunicationStepSize": "true",
        "canInterpolateInputs": str(interface.sampled).lower(),
        "maxOutputDerivativeOrder": "1" if interface.states else "0",
    }
    elements.append(ET.SubElement(root, "CoSimulation", simulation))
    for element in elements if sources else []:
        files = ET.SubElement(element, "SourceFiles")
        for name in sources:
            ET.SubElement(files, "File", name=name)
    units = sorted({v.unit for v in interface.listed})
    unit_definitions(root, units)
    types = ET.SubElement(root, "TypeDefinitions")
    for unit in units:
        if unit in TYPES:
            simple = ET.SubElement(types, "SimpleType", name=TYPES[unit])
            ET.SubElement(simple, "Real", quantity=TYPES[unit], unit=unit)
    categories = ET.SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=text)
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime="10", stepSize=repr(interface.step))
    _model_variables(root, interface.listed)
    _model_structure(root, interface)
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


def _model_structure(root: ET.Element, interface: Interface) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    index = {v.name: i + 1 for i, v in enumerate(interface.listed)}

    def places(names: frozenset[str]) -> str:
        return " ".join(str(i + 1) for i in interface.references(names))

    sections = {
        "Outputs": [v for v in interface.unknowns if not v.derivative_of],
        "Derivatives": [v for v in interface.unknowns if v.derivative_of],
    }
    for section, members in sections.items():
        element = ET.SubElement(structure, section) if members else None
        for v in members:
            assert element is not None
            unknown = ET.SubElement(element, "Unknown", index=str(index[v.name]))
            unknown.set("dependencies", places(interface.dependencies.running[v.name]))
    initial = ET.SubElement(structure, "InitialUnknowns")
    for v in interface.initial_unknowns:
        depends = places(interface.dependencies.initial[v.name])
        ET.SubElement(initial, "Unknown", index=str(index[v.name]), dependencies=depends)
