"""How a residual changes with the parameters of y = a exp(-b t), against its derivatives."""

import numpy as np
import pytest

from flexmodels.inputs import SimulationError
from pyident.greybox.recording import Recording
from pyident.greybox.search import Derivatives, Free, Search

TIME = np.linspace(0.0, 2.0, 201)
A, B = 3.0, 1.5
POINT = np.array([A, B])


def decay(values):
    return values["a"] * np.exp(-values["b"] * TIME)[:, None]


def simulate(recording, sets, names, progress=None):
    return np.stack([decay(values) for values in sets])


def of_a(recording, values, steps):
    """dy/da alone, (1, N, 1)."""
    assert set(steps) == {"a"}
    return np.exp(-values["b"] * TIME)[None, :, None]


def search(derivatives: Derivatives | None = None, low: float = -np.inf) -> Search:
    recording = Recording("log", TIME, {}, ("y",), ("m",), decay({"a": 2.0, "b": 1.0}))
    return Search([recording], simulate, [Free("a", "m", A, low), Free("b", "1/s", B)], derivatives)


def expected(of: Search) -> np.ndarray:
    wave = np.exp(-B * TIME)
    return -np.column_stack([wave, -A * TIME * wave]) / of.size


def test_differences_are_the_derivatives():
    found = search()
    np.testing.assert_allclose(found.slopes(POINT), expected(found), rtol=1e-4, atol=1e-7)


def test_at_a_bound_only_the_inner_side_is_used():
    found = search(low=A)
    np.testing.assert_allclose(found.slopes(POINT)[:, 0], expected(found)[:, 0], rtol=1e-9, atol=1e-9)


def test_the_models_own_derivatives_stand_beside_differences():
    found = search(Derivatives(frozenset({"a"}), of_a))
    assert found.own == [0]
    np.testing.assert_allclose(found.slopes(POINT), expected(found), rtol=1e-4, atol=1e-7)
    assert found.confirm(POINT)
    assert not found.note


def test_derivatives_that_are_wrong_are_used_no_more():
    def wrong(recording, values, steps):
        return 1.2 * of_a(recording, values, steps)

    found = search(Derivatives(frozenset({"a"}), wrong))
    assert not found.confirm(POINT)
    assert "disagree with differences for a" in found.note
    np.testing.assert_allclose(found.slopes(POINT), expected(found), rtol=1e-4, atol=1e-7)


def test_derivatives_that_fail_are_used_no_more():
    def failing(recording, values, steps):
        raise SimulationError("an event")

    found = search(Derivatives(frozenset({"a"}), failing))
    assert not found.confirm(POINT)
    assert found.note.endswith("an event")
    assert found.own == []


def test_where_the_model_cannot_run_it_is_far_away():
    def broken(recording, sets, names, progress=None):
        raise SimulationError("no step is small enough")

    found = search()
    found.set_worst(np.array([0.5]))
    found.simulate = broken
    assert found.residual(POINT) == pytest.approx(np.full(len(TIME), 1e3))
