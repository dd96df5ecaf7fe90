"""An FMU in model exchange, FMI 2.0 or 3.0, brought into one of its modes with everything moving."""

import ctypes
import zipfile
from xml.etree import ElementTree as ET

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, fmi2EventInfo
from fmpy.fmi3 import FMU3Model

MODES = ("initialisation", "event", "continuous")
POSE = [0.4, 0.9, -0.6, 0.3]


class Face2:
    """The calls of FMI 2.0 that `Moving` needs."""

    def __init__(self, **instance):
        self.fmu = FMU2Model(**instance)
        self.fmu.instantiate()
        self.get, self.set = self.fmu.getReal, self.fmu.setReal

    def initialise(self):
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()

    def handle_events(self):
        self.fmu.fmi2NewDiscreteStates(self.fmu.component, ctypes.byref(fmi2EventInfo()))

    def states(self, size):
        x = (ctypes.c_double * size)()
        self.fmu.fmi2GetContinuousStates(self.fmu.component, x, size)
        return np.array(x)

    def put(self, x):
        self.fmu.fmi2SetContinuousStates(self.fmu.component, (ctypes.c_double * len(x))(*x), len(x))


class Face3:
    """Those of FMI 3.0."""

    def __init__(self, **instance):
        self.fmu = FMU3Model(**instance)
        self.fmu.instantiate()
        self.get, self.set = self.fmu.getFloat64, self.fmu.setFloat64

    def initialise(self):
        self.fmu.enterInitializationMode(startTime=0.0)

    def handle_events(self):
        self.fmu.updateDiscreteStates()

    def states(self, size):
        x = (ctypes.c_double * size)()
        self.fmu.getContinuousStates(x, size)
        return np.array(x)

    def put(self, x):
        self.fmu.setContinuousStates((ctypes.c_double * len(x))(*x), len(x))


class Moving:
    """Stuck at its last joint, sliding at the others."""

    def __init__(self, path, mode):
        self.path, self.mode = path, mode
        self.description = read_model_description(str(path))
        assert self.description.modelExchange is not None
        face = Face2 if self.description.fmiVersion == "2.0" else Face3
        self.face = face(
            guid=self.description.guid,
            unzipDirectory=str(extract(str(path))),
            modelIdentifier=self.description.modelExchange.modelIdentifier,
            instanceName="arm",
        )
        self.fmu = self.face.fmu
        variables = [
            v for v in self.description.modelVariables if v.type in ("Real", "Float64") and not v.dimensions
        ]
        self.vr = {v.name: v.valueReference for v in variables}
        self.states = [v.derivative.name for v in variables if v.derivative]
        self.start()
        inputs = [v.name for v in variables if v.causality == "input"]
        free = ("fixed", "tunable") if mode == "initialisation" else ("tunable",)
        parameters = [v.name for v in variables if v.causality == "parameter" and v.variability in free]
        parameters = [name for name in parameters if name not in ("solver.step", "controller.period")]
        known = [*inputs, *parameters, *(self.states if mode != "initialisation" else [])]
        self.at = dict(zip(known, self.get(known), strict=True))
        computed = ("output", "local", "calculatedParameter")
        self.unknown = [v.name for v in variables if v.causality in computed]

    def set(self, values):
        self.face.set([self.vr[n] for n in values], list(values.values()))

    def get(self, names):
        return np.array(self.face.get([self.vr[n] for n in names]))

    def start(self):
        self.face.initialise()
        self.set({f"joint{k + 1}.r": r for k, r in enumerate(POSE)})
        self.set({f"joint{k}.de_0": 0.3 * k for k in (1, 2, 3)})
        self.set({"joint4.tau_ff": 1.0})
        self.set({"joint2.start_error": 0.01, "payload.m": 1.5, "payload.c[1]": 0.1})
        if self.mode == "initialisation":
            return
        self.fmu.exitInitializationMode()
        self.face.handle_events()
        self.fmu.enterContinuousTimeMode()
        self.fmu.setTime(0.0021)
        x = self.face.states(32)
        x[4:16] += 1e-4 * np.sin(np.arange(12))
        x[20:] = 0.05 * np.cos(np.arange(12))
        self.face.put(x)
        if self.mode == "event":
            self.fmu.setTime(0.004)
            self.fmu.enterEventMode()  # the controller's second sample is due
        self.set({"joint1.r": 0.41, "joint3.tau_ff": 2.0})

    def values(self, changes):
        """All unknowns with some knowns changed; then everything is as before."""
        self.set({name: self.at[name] + change for name, change in changes.items()})
        unknowns = self.get(self.unknown)
        self.set({name: self.at[name] for name in changes})
        return unknowns

    def step_of(self, name):
        """A change of a known whose effect stands above rounding."""
        return 1e-5 * max(abs(self.at[name]), 1e-2) if name not in self.states else 1e-6


def declared_in(fmu):
    """Unknown -> names of the knowns that modelDescription.xml lists for it in this mode."""
    with zipfile.ZipFile(fmu.path) as archive:
        root = ET.fromstring(archive.read("modelDescription.xml"))
    structure = root.find("ModelStructure")
    assert structure is not None
    first = fmu.mode == "initialisation"
    if fmu.description.fmiVersion == "2.0":
        names = [v.get("name") for v in root.iterfind("ModelVariables/ScalarVariable")]
        number, of = "index", {str(i): name for i, name in enumerate(names, start=1)}
        kinds = ["InitialUnknowns/Unknown"] if first else ["Outputs/Unknown", "Derivatives/Unknown"]
    else:
        number, of = (
            "valueReference",
            {v.attrib["valueReference"]: v.attrib["name"] for v in root.iterfind("ModelVariables/*")},
        )
        kinds = ["InitialUnknown"] if first else ["Output", "ContinuousStateDerivative", "EventIndicator"]
    return {
        of[u.attrib[number]]: {of[place] for place in u.attrib["dependencies"].split()}
        for kind in kinds
        for u in structure.iterfind(kind)
    }
