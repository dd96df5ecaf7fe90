"""What every script of this folder shares: the request that it is given, the answer that it writes.

    python <script>.py request.json answer.json

Only the standard library: the scripts run in the importers' own environments.
"""

import json
import os
import sys
import time
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
    tool         path of a tool that is no Python package
    """

    fmu: str
    interface: str
    time: list[float]
    inputs: dict[str, list[float]]
    outputs: list[str]
    event_mode: bool = False
    states: dict[str, list[float]] = field(default_factory=dict)
    tool: str = ""

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


CPU_SECONDS = "CPU seconds"  # of loading and running, a column of the answer


def read() -> Request:
    """The request; from here on the time counts, the import of the tool does not."""
    global _begun
    _begun = _cpu()
    return Request(**json.loads(Path(sys.argv[1]).read_text()))


def write(rows: dict[str, list]) -> None:
    """Variable -> its values after each communication step."""
    Path(sys.argv[2]).write_text(json.dumps(rows | {CPU_SECONDS: [_cpu() - _begun]}))


def _cpu() -> float:
    """Of this process and of its ended children [s]."""
    return time.process_time() + sum(os.times()[2:4])


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
