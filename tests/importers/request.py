"""What every script of this folder shares: the request that it is given, the answer that it writes.

    python <script>.py request.json answer.json

Only the standard library: the scripts run in the importers' own environments.
"""

import json
import sys
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET


@dataclass(frozen=True)
class Request:
    """Run the FMU over a time grid.

    fmu          path of the FMU
    interface    CoSimulation or ModelExchange
    time         communication points, evenly spaced from 0 [s]
    inputs       variable -> its values at the communication points
    outputs      variables to record
    event_mode   co-simulation in FMI 3: the importer handles the events
    states       variable -> its values at the communication points (for CasADi, which integrates nothing)
    """

    fmu: str
    interface: str
    time: list[float]
    inputs: dict[str, list[float]]
    outputs: list[str]
    event_mode: bool = False
    states: dict[str, list[float]] = field(default_factory=dict)

    @property
    def step(self) -> float:
        return self.time[1]

    @property
    def first(self) -> dict[str, float]:
        """The inputs at the first communication point, to be set before initialisation ends."""
        return {name: values[0] for name, values in self.inputs.items()}


@dataclass(frozen=True)
class Description:
    """What modelDescription.xml says, FMI 2 or 3, for importers that leave it to their user to read."""

    version: str
    token: str
    identifier: str
    references: dict[str, int]
    states: int
    indicators: int

    def of(self, names) -> list[int]:
        return [self.references[name] for name in names]


def read() -> Request:
    return Request(**json.loads(Path(sys.argv[1]).read_text()))


def write(rows: dict[str, list]) -> None:
    """Variable -> its values after each communication step."""
    Path(sys.argv[2]).write_text(json.dumps(rows))


def describe(request: Request) -> Description:
    with zipfile.ZipFile(request.fmu) as archive:
        root = ET.fromstring(archive.read("modelDescription.xml"))
    interface = root.find(request.interface)
    variables, structure = root.find("ModelVariables"), root.find("ModelStructure")
    assert interface is not None
    assert variables is not None
    assert structure is not None
    old = root.get("fmiVersion", "").startswith("2")
    states = structure.findall("Derivatives/Unknown" if old else "ContinuousStateDerivative")
    listed = str(len(structure.findall("EventIndicator")))
    return Description(
        version=root.get("fmiVersion", ""),
        token=root.get("guid" if old else "instantiationToken", ""),
        identifier=interface.get("modelIdentifier", ""),
        references={v.get("name", ""): int(v.get("valueReference", "")) for v in variables},
        states=len(states),
        indicators=int(root.get("numberOfEventIndicators", listed)),
    )
