"""FMUs driven by hand through FMPy's thin layer."""

import numpy as np
from fmpy import extract, read_model_description


class Opened:
    """An instance of an FMI 2.0 FMU in co-simulation or, by `kind`, in model exchange."""

    def __init__(self, path, kind, reference):
        self.description = read_model_description(str(path))
        assert self.description.coSimulation is not None
        self.vr = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmu = kind(
            guid=self.description.guid,
            unzipDirectory=str(extract(str(path))),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="arm",
        )
        self.start(reference)

    def start(self, reference):
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.set({f"joint{k + 1}.r": r for k, r in enumerate(reference)})
        self.fmu.exitInitializationMode()

    def set(self, values):
        self.fmu.setReal([self.vr[n] for n in values], list(values.values()))

    def get(self, names):
        return np.array(self.fmu.getReal([self.vr[n] for n in names]))
