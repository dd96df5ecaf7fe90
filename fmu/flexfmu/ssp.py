"""Equations -> SSP file: plant and controller as two FMUs, and how they are connected."""

import tempfile
from pathlib import Path
from xml.etree import ElementTree as ET

from flexfmu.build import export_controller, export_fmu, without_controller
from flexfmu.files.provenance import sign, zip_folder
from flexfmu.files.units import base_units
from flexfmu.interface import Interface, controller_interface, plant_interface
from flexfmu.package import Platforms
from flexfmu.simulate import constant_run
from flexfmu.variables import Variable
from flexmodels.atomic import replacing
from flexmodels.coordinate import motor_of, of_joint, torque_of
from flexmodels.mechanics.plant import Equations

_SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_KINDS = ("input", "output", "parameter", "calculatedParameter")


def export_ssp(equations: Equations, path: str | Path, platforms: Platforms = "host") -> Path:
    """Write SystemStructure.ssd, resources/plant.fmu and resources/controller.fmu. Raises BuildError.

    The FMUs are of FMI 2.0, the version that SSP 1.0 names.
    """
    path, plant = Path(path), without_controller(equations)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
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
    connections = _connections(parts)
    outside = _outside(parts, connections)
    system = _element(root, "System", name=equations.name, description="The arm and its digital controller")
    _connectors(system, outside)
    elements = _element(system, "Elements")
    for name, interface in parts.items():
        component = _element(
            elements,
            "Component",
            name=name,
            type="application/x-fmu-sharedlibrary",
            source=f"resources/{name}.fmu",
        )
        _connectors(component, _shown(interface))
    lines = _element(system, "Connections")
    for start, end in (*connections, *_to_outside(parts, outside)):
        ends = {"startElement": start[0], "startConnector": start[1], "endElement": end[0]}
        _element(lines, "Connection", **{k: v for k, v in ends.items() if v}, endConnector=end[1])
    units = _element(root, "Units")
    for unit in sorted({v.unit for part in parts.values() for v in part.listed}):
        element = ET.SubElement(units, f"{{{_SSC}}}Unit", name=unit)
        powers = {base: str(power) for base, power in base_units(unit).items()}
        ET.SubElement(element, f"{{{_SSC}}}BaseUnit", powers)
    _element(root, "DefaultExperiment", startTime="0", stopTime="10")
    ET.indent(root)
    return ET.tostring(root, encoding="utf-8", xml_declaration=True)


End = tuple[str, str]  # component ("": the system), connector


def _connections(parts: dict[str, Interface]) -> list[tuple[End, End]]:
    """Between the two: positions, torques, and the torques that hold the start."""
    out: list[tuple[End, End]] = []
    for k in range(1, parts["plant"].joints + 1):
        out.append((("plant", motor_of(k)), ("controller", motor_of(k))))
        out.append((("controller", torque_of(k)), ("plant", torque_of(k))))
        out.append((("plant", of_joint(k, "tau_0")), ("controller", of_joint(k, "I_0"))))
    return out


def _outside(parts: dict[str, Interface], connections: list[tuple[End, End]]) -> list[Variable]:
    """Inputs that nothing inside feeds, then every output."""
    fed = {end for _, end in connections}
    inputs, outputs = [], []
    for name, interface in parts.items():
        inputs += [v for v in interface.listed if v.causality == "input" and (name, v.name) not in fed]
        outputs += [v for v in interface.listed if v.causality == "output"]
    return [*inputs, *outputs]


def _to_outside(parts: dict[str, Interface], outside: list[Variable]) -> list[tuple[End, End]]:
    out: list[tuple[End, End]] = []
    for v in outside:
        owner = next(name for name, part in parts.items() if v in part.listed)
        inner, outer = (owner, v.name), ("", v.name)
        out.append((outer, inner) if v.causality == "input" else (inner, outer))
    return out


def _shown(interface: Interface) -> list[Variable]:
    """What a component offers for connections: no tunable parameters."""
    return [v for v in interface.listed if v.causality in _KINDS and v.variability != "tunable"]


def _connectors(parent: ET.Element, listed: list[Variable]) -> None:
    group = _element(parent, "Connectors")
    for v in listed:
        connector = _element(group, "Connector", name=v.name, kind=v.causality)
        ET.SubElement(connector, f"{{{_SSC}}}Real", unit=v.unit)


def _element(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    return ET.SubElement(parent, f"{{{_SSD}}}{tag}", attributes)
