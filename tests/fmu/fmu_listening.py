"""An instance in initialisation mode whose messages are kept."""

from typing import Any

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave, fmi3LogMessageCallback

from flexfmu.simulate import _callbacks


class Listening2:
    """FMI 2.0 co-simulation in initialisation mode, with what the FMU logs."""

    def __init__(self, path, said):
        self.said = said
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

    def start(self):
        self.fmu.exitInitializationMode()

    def step(self, time, step):
        self.fmu.doStep(time, step)

    def call(self, name, *arguments):
        """A function of the standard that must refuse; the sentence that it logs."""
        before = len(self.said)
        with pytest.raises(Exception, match="status"):
            getattr(self.fmu, self.prefix + name)(self.fmu.component, *arguments)
        assert len(self.said) == before + 1
        return self.said[-1]

    prefix = "fmi2"


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

    prefix = "fmi3"


OPENED = {2: Listening2, 3: Listening3}
