"""Sensitivities by an FMU's own directional derivatives: closed forms, SciPy, and when they do not serve."""

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint
from reference_fmus import reference_fmu
from scipy.integrate import solve_ivp

import pyident as pi
from flexfmu.foreign.model import FmuModel
from flexmodels.inputs import SimulationError

TIME = np.arange(0, 5, 0.05)
NOISE = 0.01
BOTH = pytest.mark.parametrize("fmi", [2, 3])
DECAYS = "y != vr_der_x ? 0 : x == vr_x ? -M(k) : x == vr_k ? %s : 0"
FALLS = "y == vr_der_h && x == vr_v"


def with_derivative(text):
    """Edits that give a reference FMU the derivative of y by x."""
    function = f"""
Status getPartialDerivative(ModelInstance *comp, ValueReference y, ValueReference x, double *partial) {{
    *partial = {text};
    return OK;
}}

Status getDerivatives("""
    return [
        ("model.c", "Status getDerivatives(", function),
        ("config.h", "#define SET_FLOAT64", "#define SET_FLOAT64\n#define GET_PARTIAL_DERIVATIVE"),
    ]


def dahlquist(fmi, folder, by_k="-M(x)"):
    """dx/dt = -k x with k tunable, and the FMU's word for its derivative by k."""
    word = "providesDirectionalDerivative" + ("" if fmi == 2 else "s")
    xml = f"FMI{fmi}.xml"
    edits = [
        *with_derivative(DECAYS % by_k),
        (xml, 'variability="fixed"', 'variability="tunable"'),
        (xml, "<ModelExchange", f'<ModelExchange {word}="true"'),
    ]
    return reference_fmu("Dahlquist", fmi, folder, edits)


def decay(k=1.7, seed=3):
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(TIME))
    return pd.DataFrame({"time": TIME, "x": np.exp(-k * TIME) + noise})


def van_der_pol(mu, x0, time):
    """Derivatives of both states by x0, by DOP853."""

    def rate(_, y):
        a, b, s, r = y
        return [b, mu * (1 - a * a) * b - a, r, (-2 * a * b * mu - 1) * s + mu * (1 - a * a) * r]

    span = (time[0], time[-1])
    return solve_ivp(rate, span, [x0, 0, 1, 0], "DOP853", t_eval=time, rtol=1e-11, atol=1e-12).y[2:].T


@BOTH
def test_a_decay_s_sensitivity_and_interval_are_the_closed_form_s(fmi, tmp_path):
    path = dahlquist(fmi, tmp_path)
    with FmuModel(path, "ModelExchange") as model:
        (slope,) = model.sensitivities(TIME, {}, {"k": 1.7}, {"k": 1e-6}, ["x"])
    np.testing.assert_allclose(slope[:, 0], -TIME * np.exp(-1.7 * TIME), atol=1e-6)
    fit = pi.identify_fmu(path, decay(), ["k"], interface="ModelExchange")
    (k,) = fit.fit.estimates
    assert k.slope == "directional derivatives"
    assert fit.notes == ()
    assert "slopes by directional derivatives" in fit.summary()
    assert abs(k.value - 1.7) < 3 * k.std
    bound = NOISE / np.linalg.norm(TIME * np.exp(-1.7 * TIME))
    assert k.std == pytest.approx(bound, rel=0.5)


@BOTH
def test_what_the_standard_does_not_give_is_differenced(fmi, tmp_path):
    """A fixed parameter is no known of a derivative in Continuous-Time Mode, the start of a state is one."""
    path, time = reference_fmu("VanDerPol", fmi, tmp_path), np.arange(0, 8, 0.02)
    values = {"mu": 1.6, "x0": 1.8}
    with FmuModel(path, "ModelExchange") as model:
        (slope,) = model.sensitivities(time, {}, values, {"x0": 1e-6}, ["x0", "x1"])
        courses = model.run(time, {}, [values], ["x0", "x1"])[0]
    exact = van_der_pol(1.6, 1.8, time)
    assert np.abs(slope - exact).max() < 1e-5 * np.abs(exact).max()
    log = pd.DataFrame(courses, columns=["x0", "x1"]).assign(time=time)
    fit = pi.identify_fmu(path, log, [*values], interface="ModelExchange")
    assert [e.slope for e in fit.fit.estimates] == ["differences", "directional derivatives"]
    assert fit.values == pytest.approx(values, rel=1e-5)
    in_steps = pi.identify_fmu(path, log, ["x0"], values={"mu": 1.6}, interface="CoSimulation")
    assert in_steps.fit.estimates[0].slope == "differences"


@BOTH
def test_wrong_derivatives_are_seen_and_left(fmi, tmp_path):
    """They are half of what they should be: the search still arrives, and differences do not confirm it."""
    fit = pi.identify_fmu(dahlquist(fmi, tmp_path, "-0.5 * M(x)"), decay(), ["k"], interface="ModelExchange")
    (k,) = fit.fit.estimates
    assert k.slope == "differences"
    assert "they disagree with differences for k" in fit.notes[-1]
    exact = np.exp(-1.7 * TIME)
    assert k.std == pytest.approx(NOISE / np.linalg.norm(TIME * exact), rel=0.5)


@BOTH
def test_sensitivities_end_at_an_event(fmi, tmp_path):
    path = reference_fmu("BouncingBall", fmi, tmp_path, with_derivative(FALLS))
    with FmuModel(path, "ModelExchange") as model, pytest.raises(SimulationError, match="has an event"):
        model.sensitivities(np.arange(0, 1, 0.1), {}, {"h": 1.0}, {"h": 1e-6}, ["h"])


@BOTH
def test_a_plant_without_friction_has_the_slopes_of_differences(fmi, tmp_path):
    """Driven, with an output that depends on both; a reversal would be an event."""
    robot = one_joint()
    path = pi.export_fmu(robot, tmp_path / "plant.fmu", fmi=fmi, part="plant")
    time = np.arange(0, 1, 0.004)
    inputs = {"joint1.tau": 2 + np.sin(5 * time)}
    names, outputs = ["joint1.J_m", "joint1.viscous"], ["joint1.e", "tip.x"]
    values = {"joint1.coulomb": 0.0, "joint1.J_m": 0.7, "joint1.viscous": 0.5, "joint1.de_0": 0.5}
    step = 1e-2  # the integration's error is divided by it
    with FmuModel(path, "ModelExchange") as model:
        assert all(model.has_sensitivity(name, [*inputs], outputs) for name in names)
        slopes = model.sensitivities(time, inputs, values, dict.fromkeys(names, 1e-6), outputs)
        sets = [{**values, n: values[n] + s * step} for n in names for s in (1, -1)]
        runs = model.run(time, inputs, sets, outputs)
        course = model.run(time, inputs, [values], ["joint1.e"])[0, :, 0]
    inertia, damping = 0.7 + 0.6, 0.5

    def rate(t, x):
        return [x[1], (np.interp(t, time, inputs["joint1.tau"]) - damping * x[1]) / inertia]

    exact = solve_ivp(rate, (0, time[-1]), [0, 0.5], t_eval=time, rtol=1e-10, atol=1e-12, max_step=0.004)
    assert np.abs(course - exact.y[0]).max() < 1e-6  # inputs are linear between samples
    differences = (runs[0::2] - runs[1::2]) / (2 * step)
    for own, ours in zip(slopes, differences, strict=True):
        assert np.abs(own - ours).max() < 1e-3 * np.abs(ours).max()
