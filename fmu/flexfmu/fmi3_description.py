"""modelDescription.xml and terminalsAndIcons.xml of FMI 3.0."""

from datetime import UTC, datetime
from xml.etree import ElementTree as ET

from flexfmu.fmi2_description import numbers, unit_definitions
from flexfmu.interface import Interface
from flexfmu.variables import TYPES, Array, Variable, arrays
from flexmodels.coordinate import joint_name, of_joint


def model_description(interface: Interface, token: str, derivatives: bool) -> bytes:
    """The XML file; `derivatives`: whether the binary provides directional and adjoint derivatives."""
    listed, views = interface.listed, arrays(interface.joints)
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=interface.name,
        instantiationToken=token,
        description=interface.description,
        generationTool="flexident",
        generationDateAndTime=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        variableNamingConvention="structured",
    )
    common = {
        "modelIdentifier": interface.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
        "providesDirectionalDerivatives": str(derivatives).lower(),
        "providesAdjointDerivatives": str(derivatives).lower(),
    }
    ET.SubElement(root, "ModelExchange", common)
    ET.SubElement(
        root,
        "CoSimulation",
        common
        | {
            "canHandleVariableCommunicationStepSize": "true",
            "maxOutputDerivativeOrder": "1",
            "providesIntermediateUpdate": "true",
            "mightReturnEarlyFromDoStep": "true",
            "canReturnEarlyAfterIntermediateUpdate": "true",
            "hasEventMode": "true",
        },
    )
    units = sorted({v.unit for v in listed})
    unit_definitions(root, units)
    types = ET.SubElement(root, "TypeDefinitions")
    for unit in units:
        if unit in TYPES:
            ET.SubElement(types, "Float64Type", name=TYPES[unit], quantity=TYPES[unit], unit=unit)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError", description="What was refused, and why")
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime="10", stepSize=repr(interface.step))
    _model_variables(root, listed, views)
    _model_structure(root, interface)
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def terminals(interface: Interface) -> bytes:
    """terminalsAndIcons.xml: per joint a terminal with its signals."""
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    group = ET.SubElement(root, "Terminals")
    names = {v.name for v in interface.listed}
    for k in range(1, interface.joints + 1):
        terminal = ET.SubElement(
            group, "Terminal", name=joint_name(k), matchingRule="bus", description=f"Signals of joint {k}"
        )
        for signal in ("r", "tau_ff", "e", "tau"):
            if of_joint(k, signal) in names:
                ET.SubElement(
                    terminal,
                    "TerminalMemberVariable",
                    variableName=of_joint(k, signal),
                    memberName=signal,
                    variableKind="signal",
                )
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def _model_variables(root: ET.Element, listed: list[Variable], views: list[Array]) -> None:
    element = ET.SubElement(root, "ModelVariables")
    reference = {v.name: i for i, v in enumerate(listed)}
    ET.SubElement(
        element,
        "Float64",
        name="time",
        valueReference=str(len(listed)),
        causality="independent",
        variability="continuous",
        description="Simulation time",
        unit="s",
    )
    for v in listed:
        variable = ET.SubElement(
            element,
            "Float64",
            name=v.name,
            valueReference=str(reference[v.name]),
            description=v.description,
            causality=v.causality,
            variability=v.variability,
        )
        if v.initial:
            variable.set("initial", v.initial)
        for key, value in numbers(v).items():
            variable.set(key, value)
        if v.derivative_of:
            variable.set("derivative", str(reference[v.derivative_of]))
    for i, array in enumerate(views):
        first = listed[reference[array.first]]
        variable = ET.SubElement(
            element,
            "Float64",
            name=array.name,
            valueReference=str(len(listed) + 1 + i),
            description=array.description,
            causality="local",  # many importers read one number for every output
            variability=first.variability,
            initial="calculated",
        )
        for key, value in numbers(first).items():
            variable.set(key, value)
        ET.SubElement(variable, "Dimension", start=str(array.size))


def _model_structure(root: ET.Element, interface: Interface) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    listed = interface.listed
    reference = {v.name: i for i, v in enumerate(listed)}
    for v in interface.unknowns:
        kind = "ContinuousStateDerivative" if v.derivative_of else "Output"
        element = ET.SubElement(structure, kind, valueReference=str(reference[v.name]))
        depends = (str(reference[name]) for name in interface.dependencies(v))
        element.set("dependencies", " ".join(depends))
    at_start = [v.name for v in listed if v.causality in ("input", "parameter") and v.name != "solver.step"]
    depends = " ".join(str(reference[name]) for name in at_start)
    for vr in interface.initial_unknowns:
        ET.SubElement(structure, "InitialUnknown", valueReference=str(vr), dependencies=depends)
    for k in range(1, interface.indicators + 1):
        ET.SubElement(
            structure, "EventIndicator", valueReference=str(reference[of_joint(k, "friction_margin")])
        )
