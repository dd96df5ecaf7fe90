"""An FMI 2.0 FMU in model exchange, brought into one of its modes with everything moving."""

import ctypes

import numpy as np
from fmpy.fmi2 import FMU2Model, fmi2EventInfo
from fmu_by_hand import Opened

MODES = ("initialisation", "event", "continuous")
POSE = [0.4, 0.9, -0.6, 0.3]


class Moving(Opened):
    """Stuck at its last joint, sliding at the others."""

    def __init__(self, path, mode):
        self.mode = mode
        super().__init__(path, FMU2Model, POSE)
        variables = self.description.modelVariables
        self.states = [v.derivative.name for v in variables if v.derivative]
        self.starts = {v.name: float(v.start) for v in variables if v.causality == "parameter"}  # pyright: ignore[reportArgumentType]
        inputs = [v.name for v in variables if v.causality == "input"]
        free = ("fixed", "tunable") if mode == "initialisation" else ("tunable",)
        parameters = [v.name for v in variables if v.causality == "parameter" and v.variability in free]
        parameters = [name for name in parameters if name not in ("solver.step", "controller.period")]
        known = [*inputs, *parameters, *(self.states if mode != "initialisation" else [])]
        self.at = dict(zip(known, self.get(known), strict=True))
        computed = ("output", "local", "calculatedParameter")
        self.unknown = [v.name for v in variables if v.causality in computed]

    def start(self, reference):
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.set({f"joint{k + 1}.r": r for k, r in enumerate(reference)})
        self.set({f"joint{k}.de_0": 0.3 * k for k in (1, 2, 3)})
        self.set({"joint4.tau_ff": 1.0})
        self.set({"joint2.start_error": 0.01, "payload.m": 1.5, "payload.c[1]": 0.1})
        if self.mode == "initialisation":
            return
        self.fmu.exitInitializationMode()
        self.handled()
        self.fmu.enterContinuousTimeMode()
        self.fmu.setTime(0.0021)
        x = np.zeros(32)
        pointer = x.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        self.fmu.fmi2GetContinuousStates(self.fmu.component, pointer, 32)
        x[4:16] += 1e-4 * np.sin(np.arange(12))
        x[20:] = 0.05 * np.cos(np.arange(12))
        self.fmu.fmi2SetContinuousStates(self.fmu.component, pointer, 32)
        if self.mode == "event":
            self.fmu.setTime(0.004)
            self.fmu.enterEventMode()  # the controller's second sample is due
        self.set({"joint1.r": 0.41, "joint3.tau_ff": 2.0})

    def handled(self):
        self.fmu.fmi2NewDiscreteStates(self.fmu.component, ctypes.byref(fmi2EventInfo()))

    def values(self, changes):
        """All unknowns with some knowns changed; then everything is as before."""
        self.set({name: self.at[name] + change for name, change in changes.items()})
        found = self.get(self.unknown)
        self.set({name: self.at[name] for name in changes})
        return found

    def step_of(self, name):
        """A change of a known whose effect stands above rounding."""
        return 1e-5 * max(abs(self.at[name]), 1e-2) if name not in self.states else 1e-6
