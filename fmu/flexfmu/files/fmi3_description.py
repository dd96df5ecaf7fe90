"""modelDescription.xml and terminalsAndIcons.xml of FMI 3.0."""

from dataclasses import replace
from xml.etree import ElementTree as ET

from flexfmu.files.fmi2_description import LOG_CATEGORIES, numbers, unit_definitions
from flexfmu.files.provenance import sign
from flexfmu.files.units import TYPES
from flexfmu.interface import Interface
from flexfmu.variable import Array, Variable, arrays
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
        variableNamingConvention="structured",
    )
    sign(root)
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
    for name, text in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=text)
    ET.SubElement(root, "DefaultExperiment", startTime="0", stopTime="10", stepSize=repr(interface.step))
    _model_variables(root, listed, views)
    if interface.sampled:
        _clock(root[-1], len(listed) + 1 + len(views))
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
        for key, value in numbers(replace(first, start=None)).items():  # it only shows what an input may hold
            variable.set(key, value)
        ET.SubElement(variable, "Dimension", start=str(array.size))


def _clock(variables: ET.Element, reference: int) -> None:
    ET.SubElement(
        variables,
        "Clock",
        name="controller.clock",
        valueReference=str(reference),
        description="Ticks when the controller takes a sample",
        causality="local",
        variability="discrete",
        intervalVariability="triggered",
    )


def _model_structure(root: ET.Element, interface: Interface) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    listed = interface.listed
    reference = {v.name: i for i, v in enumerate(listed)}

    def places(names: frozenset[str]) -> str:
        return " ".join(map(str, interface.references(names)))

    for v in interface.unknowns:
        kind = "ContinuousStateDerivative" if v.derivative_of else "Output"
        element = ET.SubElement(structure, kind, valueReference=str(reference[v.name]))
        element.set("dependencies", places(interface.dependencies.running[v.name]))
    for v in interface.initial_unknowns:
        depends = places(interface.dependencies.initial[v.name])
        vr = str(reference[v.name])
        ET.SubElement(structure, "InitialUnknown", valueReference=vr, dependencies=depends)
    for k in range(1, interface.indicators + 1):
        name = of_joint(k, "friction_margin")
        depends = places(interface.dependencies.running[name])
        vr = str(reference[name])
        ET.SubElement(structure, "EventIndicator", valueReference=vr, dependencies=depends)
