"""Held-out logs of an arm in another state than in the fitted log: what is said of them."""

from dataclasses import replace

import pytest
from six_axis_logs import arm, made, plain

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


def colder(q, v, load, time):
    """Joint 2 rubs by a third more."""
    out = plain(q, v, load, time)
    out[:, 1] *= 1.3
    return out


@pytest.fixture(scope="module")
def search():
    return searched(arm(), [made(arm(), 0, plain, 20.0)], never)


def exchanged(log):
    return _changed(log, "joint3.tau", lambda tau: 0.93 * tau)


def zeroed(log):
    return _changed(log, "joint4.tau", lambda tau: tau + 1.5)


def _changed(log, name, change):
    log.frame[name] = change(log.frame[name])
    return log


@pytest.mark.parametrize(
    ("change", "friction", "joint", "told", "size"),
    [
        (lambda log: log, colder, "joint2", "its friction", "joint2.coulomb by +2.7 N.m"),
        (exchanged, plain, "joint3", "the gain of its torque", "0.93 times"),
        (zeroed, plain, "joint4", "the zero of its torque", "by +1.5 N.m"),
    ],
)
def test_what_differs_in_a_held_out_log_is_told(search, change, friction, joint, told, size):
    held = change(made(arm(), 7, friction, 20.0))
    found = concluded(search, never, [held])
    assert found.verdict == "nothing_detectable"
    assert f"times its floor at {joint}, where {told} differs" in found.sentence
    (note,) = [n for n in found.notes if "times with its own" in n]
    assert size in note


def test_a_part_of_the_fitted_log_is_called_one(search):
    held = replace(made(arm(), 7, colder, 20.0), source="log 0")
    assert "But the held-out part of log 0 leaves" in concluded(search, never, [held]).sentence


def test_a_log_in_the_same_state_is_not_spoken_of(search):
    found = concluded(search, never, [made(arm(), 8, plain, 12.0)])
    assert "But" not in found.sentence
    assert not [n for n in found.notes if "times with its own" in n]
