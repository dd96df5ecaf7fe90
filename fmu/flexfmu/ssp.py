"""Equations -> SSP file: plant and controller as two FMUs, and how they are connected."""

from pathlib import Path
from xml.etree import ElementTree as ET

from flexfmu.build import export_controller, export_fmu, with_drives
from flexfmu.files.provenance import sign, zip_folder
from flexfmu.files.units import base_units
from flexfmu.interface import Interface, controller_interface, plant_interface
from flexfmu.law import SAMPLED, law_names
from flexfmu.package import Platforms
from flexfmu.simulate import constant_run
from flexfmu.variable import Variable
from flexmodels.atomic import replacing
from flexmodels.coordinate import of_joint
from flexmodels.mechanics.plant import Equations
from flexmodels.scratch import scratch_folder

_SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"


def export_ssp(equations: Equations, path: str | Path, platforms: Platforms = "host") -> Path:
    """Write SystemStructure.ssd, resources/plant.fmu and resources/controller.fmu. Raises BuildError.

    The FMUs are of FMI 2.0, the version that SSP 1.0 names. Positions and torques are connected; references
    and feed-forward torques are inputs of the component `controller`. The system has no connectors of its own
    and connects no parameters: simple masters know neither.
    """
    path, plant = Path(path), with_drives(equations)
    with scratch_folder() as root:
        resources = root / "resources"
        resources.mkdir()
        export_fmu(plant, resources / "plant.fmu", 2, platforms)
        integral = _holding_torques(plant, resources / "plant.fmu")
        export_controller(equations, integral, resources / "controller.fmu", platforms)
        parts = {
            "plant": plant_interface(plant),
            "controller": controller_interface(equations, integral),
        }
        (root / "SystemStructure.ssd").write_bytes(_structure(equations, parts))
        with replacing(path) as file:
            zip_folder(root, file)
    return path


def _holding_torques(plant: Equations, fmu: Path) -> dict[str, float]:
    """Start of the controller's integrals: what the plant itself says holds it at its default start."""
    joints = range(1, plant.joints + 1)
    step = plant_interface(plant).step
    run = constant_run(fmu, {}, step, step, tuple(of_joint(k, "tau_0") for k in joints))
    return {of_joint(k, "I_0"): float(run[of_joint(k, "tau_0")].iloc[0]) for k in joints}


def _structure(equations: Equations, parts: dict[str, Interface]) -> bytes:
    ET.register_namespace("ssd", _SSD)
    ET.register_namespace("ssc", _SSC)
    root = ET.Element(
        f"{{{_SSD}}}SystemStructureDescription",
        version="1.0",
        name=equations.name,
    )
    sign(root)
    system = _element(root, "System", name=equations.name, description="The arm and its digital controller")
    elements = _element(system, "Elements")
    for name, interface in parts.items():
        component = _element(
            elements,
            "Component",
            name=name,
            type="application/x-fmu-sharedlibrary",
            source=f"resources/{name}.fmu",
            implementation="CoSimulation",
        )
        _connectors(component, [v for v in interface.listed if v.causality in ("input", "output")])
    lines = _element(system, "Connections")
    for k in range(1, equations.joints + 1):
        motion = [("plant", "controller", of_joint(k, signal)) for signal in ("e", "de")]
        law = [("controller", "plant", name) for name in law_names(k)]
        for start, end, name in (*motion, *law):
            _connect(lines, start, end, name)
    _connect(lines, "controller", "plant", SAMPLED)
    units = _element(root, "Units")
    for unit in sorted({v.unit for part in parts.values() for v in part.listed}):
        element = ET.SubElement(units, f"{{{_SSC}}}Unit", name=unit)
        powers = {base: str(power) for base, power in base_units(unit).items()}
        ET.SubElement(element, f"{{{_SSC}}}BaseUnit", powers)
    _element(root, "DefaultExperiment", startTime="0", stopTime="10")
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


def _connectors(parent: ET.Element, listed: list[Variable]) -> None:
    group = _element(parent, "Connectors")
    for v in listed:
        connector = _element(group, "Connector", name=v.name, kind=v.causality)
        ET.SubElement(connector, f"{{{_SSC}}}Real", unit=v.unit)


def _connect(parent: ET.Element, start: str, end: str, name: str) -> None:
    ends = {"startElement": start, "startConnector": name, "endElement": end, "endConnector": name}
    _element(parent, "Connection", **ends)


def _element(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    return ET.SubElement(parent, f"{{{_SSD}}}{tag}", attributes)
