"""Hidden parameters of FMUs that others wrote, FMI 2 and 3, co-simulation and model exchange."""

import numpy as np
import pandas as pd
import pytest
from reference_fmus import reference_fmu

from flexfmu.foreign.model import FmuModel
from pyident.verbs.fmu.model import compare_fmu, diagnose_fmu, identify_fmu

KINDS = [(2, "CoSimulation"), (2, "ModelExchange"), (3, "CoSimulation"), (3, "ModelExchange")]
pytestmark = [pytest.mark.slow, pytest.mark.parametrize(("fmi", "interface"), KINDS)]


def recorded(path, interface, values, time, outputs, noise=0.0, seed=0):
    """A log of the FMU itself with other values, and white noise."""
    with FmuModel(path, interface) as fmu:
        courses = fmu.run(time, {}, [values], outputs)[0]
    courses = courses + noise * np.random.default_rng(seed).normal(size=courses.shape)
    return pd.DataFrame(dict(zip(outputs, courses.T, strict=True))).assign(time=time)


def test_the_decay_rate_of_dahlquist(fmi, interface, tmp_path):
    """Against the closed form too: x = exp(−k t), in co-simulation by Euler steps of 0.1 s."""
    path, time = reference_fmu("Dahlquist", fmi, tmp_path), np.arange(0, 5, 0.1)
    exact = np.exp(-1.7 * time) if interface == "ModelExchange" else (1 - 0.17) ** np.arange(50)
    log = pd.DataFrame({"time": time, "x": exact + 0.01 * np.random.default_rng(3).normal(size=50)})
    fit = identify_fmu(path, log, ["k"], interface=interface)
    k = fit.fit.estimates[0]
    assert abs(k.value - 1.7) < 3 * k.std
    slope = -time * exact if interface == "ModelExchange" else -0.1 * np.arange(50) * exact / (1 - 0.17)
    assert k.std == pytest.approx(0.01 / np.linalg.norm(slope), rel=0.5)  # of the Cramér-Rao bound
    assert fit.to_dict()["residuals"]["the data frame"]["x"]["rmse"] == pytest.approx(0.01, rel=0.3)


def test_damping_and_start_of_van_der_pol(fmi, interface, tmp_path):
    path = reference_fmu("VanDerPol", fmi, tmp_path)
    values = {"mu": 1.6, "x0": 1.8}
    log = recorded(path, interface, values, np.arange(0, 8, 0.02), ["x0", "x1"], 0.02)
    fit = identify_fmu(path, log, ["mu", "x0"], interface=interface)
    for estimate in fit.fit.estimates:
        assert abs(estimate.value - values[estimate.free.name]) < 4 * estimate.std
        assert estimate.std < 0.005


def test_bounces_of_a_ball(fmi, interface, tmp_path):
    """Events: g and e within bounds."""
    path = reference_fmu("BouncingBall", fmi, tmp_path)
    values = {"g": -8.5, "e": 0.62}
    log = recorded(path, interface, values, np.arange(0, 1.6, 0.01), ["h"], 0.001)
    bounds = {"g": (-12.0, -6.0), "e": (0.3, 0.95)}
    fit = identify_fmu(path, log, bounds, interface=interface)
    assert fit.values == pytest.approx(values, rel=3e-3)


def test_a_stair_that_comes_late(fmi, interface, tmp_path):
    """Nothing to identify, an output that is no real number, and a delay of 0.3 s."""
    path = reference_fmu("Stair", fmi, tmp_path)
    time = np.arange(0, 9, 0.05)
    log = recorded(path, interface, {}, time, ["counter"])
    assert compare_fmu(path, log, interface=interface).errors["the data frame"]["counter"]["rmse"] == 0
    assert diagnose_fmu(path, log, interface=interface).verdict == "nothing_detectable"
    late = log.assign(counter=np.r_[[1.0] * 6, log["counter"].to_numpy()[:-6]])
    shown = diagnose_fmu(path, late, interface=interface)
    finding = shown.outputs[0].findings[0]
    assert finding.kind == "delay"
    assert finding.at == pytest.approx(0.3, abs=0.05)
