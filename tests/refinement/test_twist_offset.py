"""Encoders of motor and link whose zeros differ: a shift of what they read, made without the law."""

import numpy as np
import pytest
from two_link_logs import loaded, made_log, two_link

import pyident as pi
from pyident.logs.log import Log

ZERO = 2e-4  # rad


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Log:
    with loaded(two_link(), tmp_path_factory.mktemp("zero")) as fmu:
        made = made_log(fmu, two_link(), 1, seconds=8.0)
    frame = made.frame.copy()
    frame["joint1.eps[1]"] = frame["joint1.eps[1]"] + ZERO
    return Log(frame, "shifted")


def offset(fit: pi.Fit) -> tuple[float, float]:
    """Of the motor's torque, in standard deviations from the true 2 N m; and the stiffness, in shares."""
    found, true = fit.identified, two_link().parameters
    value, std = (
        float(x[found.reduced.columns.index("joint1.offset")]) for x in (found.solution.p, found.solution.std)
    )
    return abs(value - true["joint1.offset"]) / std, abs(found.robot.parameters["joint1.k[1]"] / 6e4 - 1)


def test_the_law_takes_the_zero_which_the_offset_takes_otherwise(log):
    plain = pi.identify(two_link(), log)
    without, stiffness = offset(plain)
    assert np.isnan(without)  # its torque goes into the motor's offset, and rounds do not settle
    assert any("had not settled" in note for note in plain.notes)
    fit = pi.identify(two_link().with_effect(1, "twist_offset"), log)
    within, better = offset(fit)
    assert within < 3
    assert better < min(stiffness, 1e-3)
    found = fit.identified
    at = found.reduced.columns.index("joint1.twist_offset.torque")
    assert found.solution.p[at] == pytest.approx(-6e4 * ZERO, abs=3 * found.solution.std[at])
    assert np.isfinite(found.solution.std[at])
    assert found.solution.std[at] < 0.005 * 6e4 * ZERO
