"""What an FMU must not take: it refuses with a sentence and keeps its value."""

from typing import Any

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave, fmi3LogMessageCallback

from flexfmu.simulate import _callbacks


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("joint1.k[1]", -1.0),
        ("joint2.J_m", 0.0),
        ("link2.m", -0.1),
        ("joint3.coulomb", float("nan")),
        ("joint1.e", 0.3),
    ],
)
@pytest.mark.parametrize("fmi", [2, 3])
def test_wrong_values_are_refused_with_a_sentence(fmus, fmi, name, value):
    said = []
    opened = OPENED[fmi](fmus[fmi], said)
    vr = opened.vr[name]
    before = opened.read(vr)
    with pytest.raises(Exception, match="status"):
        opened.write(vr, value)
    assert opened.read(vr) == before
    assert len(said) == 1
    assert name in said[0]
    assert said[0].endswith(".")


class Listening2:
    """FMI 2.0 co-simulation in initialisation mode, with what the FMU logs."""

    def __init__(self, path, said):
        description = read_model_description(str(path))
        assert description.coSimulation is not None
        self.vr = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = self.kind(
            guid=description.guid,
            unzipDirectory=str(extract(str(path))),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="arm",
        )
        self.begin(said)

    kind: Any = FMU2Slave

    def begin(self, said):
        self.fmu.instantiate(callbacks=_callbacks(said))
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()

    def read(self, vr):
        return self.fmu.getReal([vr])[0]

    def write(self, vr, value):
        self.fmu.setReal([vr], [value])


class Listening3(Listening2):
    """The same in FMI 3.0."""

    kind: Any = FMU3Slave

    def begin(self, said):
        self.keep = fmi3LogMessageCallback(lambda *words: said.append(words[-1].decode()))
        self.fmu.instantiate(logMessage=self.keep)
        self.fmu.enterInitializationMode()

    def read(self, vr):
        return self.fmu.getFloat64([vr])[0]

    def write(self, vr, value):
        self.fmu.setFloat64([vr], [value])


OPENED = {2: Listening2, 3: Listening3}
