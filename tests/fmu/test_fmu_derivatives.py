"""Directional and adjoint derivatives against finite differences and each other."""

import ctypes

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, fmi2EventInfo
from fmpy.fmi3 import FMU3Model
from fmu_by_hand import Opened

TIP = ["tip.x", "tip.y", "tip.z"]


class Exchange(Opened):
    """Model exchange at a moving state with a torque."""

    def __init__(self, path):
        super().__init__(path, FMU2Model, [0.4, 0.9, -0.6, 0.3])
        rng = np.random.default_rng(6)
        info = fmi2EventInfo()
        self.fmu.fmi2NewDiscreteStates(self.fmu.component, ctypes.byref(info))
        self.names = list(states_of(self.description))
        x = np.r_[
            0.4, 0.9, -0.6, 0.3, 1e-3 * rng.normal(size=12), rng.uniform(0.5, 1, 4), 0.1 * rng.normal(size=12)
        ]
        self.put(x)
        self.fmu.fmi2NewDiscreteStates(self.fmu.component, ctypes.byref(info))
        self.set({"joint1.r": 0.5, "joint2.r": 1.0})
        self.put(x)
        self.x = x

    def put(self, x):
        x = np.ascontiguousarray(x)
        self.fmu.fmi2SetContinuousStates(
            self.fmu.component, x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), 32
        )


def states_of(description):
    return [v.derivative.name for v in description.modelVariables if v.derivative]


def test_directional_derivatives_are_those_of_finite_differences(fmus):
    opened = Exchange(fmus[2])
    opened.fmu.enterContinuousTimeMode()
    known = [*opened.names, "joint1.viscous", "link3.m", "joint2.k[1]"]
    unknown = [*(f"der({n})" for n in opened.names), *TIP]
    steps = {n: 1e-7 for n in opened.names} | {"joint1.viscous": 1e-3, "link3.m": 1e-4, "joint2.k[1]": 1.0}
    for i, name in enumerate(known):
        exact = opened.fmu.getDirectionalDerivative([opened.vr[n] for n in unknown], [opened.vr[name]], [1.0])
        values = []
        for sign in (1, -1):
            if i < 32:
                x = opened.x.copy()
                x[i] += sign * steps[name]
                opened.put(x)
                values.append(opened.get(unknown))
                opened.put(opened.x)
            else:
                start = opened.get([name])[0]
                opened.set({name: start + sign * steps[name]})
                values.append(opened.get(unknown))
                opened.set({name: start})
        numeric = (values[0] - values[1]) / (2 * steps[name])
        rounding = 4e-16 * np.abs(values[0]).max() / steps[name]
        atol = 2e-6 * np.abs(numeric).max() + 1e-9 + rounding
        np.testing.assert_allclose(exact, numeric, rtol=2e-5, atol=atol)


def test_the_adjoint_is_the_transpose(fmus):
    description = read_model_description(str(fmus[3]))
    assert description.modelExchange is not None
    vr = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU3Model(
        guid=description.guid,
        unzipDirectory=str(extract(str(fmus[3]))),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="arm",
    )
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.updateDiscreteStates()
    fmu.enterContinuousTimeMode()
    names = states_of(description)
    known = [vr[n] for n in (*names, "joint2.viscous", "link4.m")]
    unknown = [vr[f"der({n})"] for n in names] + [vr[n] for n in TIP]
    rng = np.random.default_rng(1)
    v, w = rng.normal(size=len(known)), rng.normal(size=len(unknown))
    forward = np.zeros(len(unknown))
    backward = np.zeros(len(known))

    def vector(values, kind):
        return (kind * len(values))(*values)

    u32, f64 = ctypes.c_uint32, ctypes.c_double
    jv, wj = vector(forward, f64), vector(backward, f64)
    a, b = vector(unknown, u32), vector(known, u32)
    fmu.fmi3GetDirectionalDerivative(fmu.component, a, len(a), b, len(b), vector(v, f64), len(v), jv, len(jv))
    fmu.fmi3GetAdjointDerivative(fmu.component, a, len(a), b, len(b), vector(w, f64), len(w), wj, len(wj))
    left, right = float(w @ np.array(jv)), float(v @ np.array(wj))
    assert left == pytest.approx(right, rel=1e-10)
    assert abs(left) > 1.0
