"""Rounds of the instrumental estimate where nothing but its instruments comes of a simulation."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pyident.refinement import auxiliary_model
from pyident.refinement.instruments.missed import NotFollowedError
from pyident.refinement.instruments.one_round import Round


class Robot:
    @property
    def linear_parameters(self) -> dict[str, float]:
        return {}

    def with_parameters(self, _):
        return self


def fake_round(number, ratio):
    """over: times what any other parameters leave in its equations."""
    return SimpleNamespace(
        number=number, over=lambda _: ratio, columns=None, gap=np.zeros(0), std=np.ones(1),
        largest=lambda _: 1.0, solution=SimpleNamespace(p=np.zeros(0)),
    )  # fmt: skip


def settled(ratios, monkeypatch) -> Any:
    made: Any = SimpleNamespace(share=1.0, wanted=Robot())
    monkeypatch.setattr(auxiliary_model, "driven", lambda _: False)
    monkeypatch.setattr(auxiliary_model, "reads_load", lambda _: False)
    monkeypatch.setattr(auxiliary_model, "Followers", lambda *_: SimpleNamespace(towards=lambda *_: made))
    rounds = iter(fake_round(i, ratio) for i, ratio in enumerate(ratios))
    monkeypatch.setattr(auxiliary_model, "next_round", lambda *_: next(rounds))
    start: Any = SimpleNamespace(robot=Robot(), data=[], plain=SimpleNamespace(reduced=None))
    best: Any = SimpleNamespace(robot=Robot(), solution=SimpleNamespace(p=np.zeros(0)))
    nothing: Any = None
    return auxiliary_model._rounds(start, [], best, nothing)


def test_a_round_that_leaves_much_more_than_the_one_before_is_the_end(monkeypatch):
    assert settled([1.05, 1.02, 4.0], monkeypatch).number == 1


def test_rounds_that_leave_as_much_go_on(monkeypatch):
    assert settled([1.05] + 7 * [1.02], monkeypatch).number == 7


def test_a_first_round_that_leaves_many_times_what_the_start_does_is_refused(monkeypatch):
    with pytest.raises(NotFollowedError, match="40 times as much is left"):
        settled([40.0, 2000.0], monkeypatch)


def test_what_a_round_leaves_is_weighed_as_its_equations_are():
    rows: Any = SimpleNamespace(share=np.ones((4, 2)), residual=lambda p: np.full((4, 2), p) * [1.0, 10.0])
    equations: Any = SimpleNamespace(weights=np.array([1.0, 0.1]))
    rest: dict[str, Any] = dict.fromkeys(("logs", "frames", "gap", "std", "columns"))
    found = Round(rows=[rows], equations=equations, solution=SimpleNamespace(p=3.0), **rest)  # pyright: ignore[reportArgumentType]
    assert found.over(np.array(1.5)) == pytest.approx(2.0)
