"""A value far from zero, and the same on held-out logs, counts though it explains next to nothing."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pyident.conditioning.alignment import Alignment
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.search import gate, wrong_description
from pyident.diagnosis.search import measured as module
from pyident.diagnosis.search.found import Step
from pyident.diagnosis.search.held_out import Unseen
from pyident.diagnosis.search.measured import measured
from pyident.rules.rules import RULES

AXIS = Candidate("axis[y]", 2)
SEEN_AGAIN = Unseen(0.02, 0.005, 0.1, 0.9)  # 8 standard deviations, at 0.95 of its size
COUNT = 4000


def search(size: float, stands_out: bool = False, late: float = 0.0, value: float = 1.0) -> Any:
    """Of white residuals that hold a sine of `size` times their standard deviation, and lose it.

    value   of the error that takes it
    """
    noise = np.random.default_rng(0).standard_normal((1, COUNT))
    sine = size * np.sin(0.1 * np.arange(COUNT))
    after = SimpleNamespace(base=SimpleNamespace(residual=[noise]))
    taken = SimpleNamespace(energy=float(np.sum(sine**2)), coefficients=np.array([value]))
    setting = SimpleNamespace(alignment=Alignment(late), robot=None, logs=None, period=0.01)
    return cast(
        Any,
        SimpleNamespace(
            rules=RULES.search,
            robot=SimpleNamespace(controller=None, flexible=False),
            examination=SimpleNamespace(setting=setting, logs=None),
            gain_of=lambda _: taken,
            stands_out=stands_out,
            over_floor=np.full(2, 1.21),
            base=SimpleNamespace(residual=[noise + sine]),
            with_further=lambda _: after,
        ),
    )


@pytest.fixture(autouse=True)
def replicas_show_noise_and_all_is_motion(monkeypatch):
    monkeypatch.setattr(module, "_in_replicas", lambda *_: np.ones(20))
    monkeypatch.setattr(module, "where_moving", lambda *_: [np.ones((1, COUNT), bool)])


@pytest.mark.parametrize(("value", "counts"), [(0.003, True), (-0.003, False)])
def test_a_torque_that_is_ahead_of_its_time_counts_by_its_share_alone(value, counts):
    """3 ms, of samples of 10 ms."""
    assert measured(search(0.3, value=value), replace(AXIS, effect="torque_lag"), SEEN_AGAIN) == counts


def test_what_replicas_show_as_well_is_no_error(monkeypatch):
    monkeypatch.setattr(module, "_in_replicas", lambda *_: np.full(20, 36.0))
    assert not measured(search(0.3), AXIS, SEEN_AGAIN)


@pytest.mark.parametrize(("replica", "counts"), [(20.0, True), (200.0, False)])  # the data: 180
def test_one_replica_that_shows_as_much_is_one_too_many(replica, counts, monkeypatch):
    """Of this error: what any replica shows of others does not matter."""
    energies = np.array([replica, *np.ones(19)])
    monkeypatch.setattr(module, "_in_replicas", lambda *_: energies)
    assert measured(search(0.3), AXIS, SEEN_AGAIN) == counts


def test_what_lies_beyond_the_frequencies_of_the_motion_is_no_evidence(monkeypatch):
    """An error that takes only what a low pass left of noise, or a controller's answer to it."""
    slow = np.arange(COUNT)[None, :] < COUNT // 2
    monkeypatch.setattr(module, "where_moving", lambda *_: [slow])
    view = search(0.3)
    (before,), (after,) = view.base.residual, view.with_further(None).base.residual
    before[slow] = after[slow]
    assert not measured(view, AXIS, SEEN_AGAIN)


@pytest.mark.parametrize(("value", "counts"), [(0.003, False), (0.02, True)])
def test_a_gain_is_known_to_a_hundredth_at_best(value, counts):
    assert measured(search(0.3, value=value), replace(AXIS, effect="torque_gain"), SEEN_AGAIN) == counts


@pytest.mark.parametrize(("value", "counts"), [(0.0015, False), (0.0025, True)])  # s, of samples of 10 ms
def test_a_lag_is_known_to_a_fifth_of_a_sample_at_best(value, counts):
    assert measured(search(0.3, value=value), replace(AXIS, effect="torque_lag"), SEEN_AGAIN) == counts


@pytest.mark.parametrize(("size", "counts"), [(0.3, True), (0.02, False)])  # 13 and 1 standard deviations
def test_far_from_zero(size, counts):
    assert measured(search(size), AXIS, SEEN_AGAIN) == counts


@pytest.mark.parametrize(
    "unseen",
    [
        None,
        Unseen(0.02, 0.02, 0.1, 0.9),  # two deviations
        Unseen(0.02, 0.0005, 0.1, 1.8),  # 1.4 times its size
        Unseen(0.02, 0.0005, 0.1, 0.2),  # 0.6 times
        Unseen(0.02, 0.006, 0.1, 3.4),  # 2.2 times, though each is known to a fifth only
    ],
)
def test_held_out_logs_must_find_the_same(unseen):
    assert not measured(search(0.3), AXIS, unseen)


@pytest.mark.parametrize(("beside", "counts"), [(0.3, True), (0.0, False)])
def test_where_positions_were_moved_in_time_an_error_is_what_a_further_move_is_not(
    beside, counts, monkeypatch
):
    """beside: what the error takes where a move takes its part first."""
    monkeypatch.setattr(module, "_beside_a_delay", lambda *_: search(beside, late=0.004))
    assert measured(search(0.3, late=0.004), AXIS, SEEN_AGAIN) == counts


def test_torques_that_were_sharpened_show_no_such_error():
    view = search(0.3)
    view.examination.setting.alignment = Alignment(corner=10.0)
    assert not measured(view, AXIS, SEEN_AGAIN)


@pytest.mark.parametrize(("std", "kept"), [(0.003, 1.8), (0.006, 2.6)])
def test_sizes_that_differ_by_chance_are_one_size(std, kept):
    """1.4 times the size, known to some ten per cent; 1.8 times, known to a fifth."""
    assert measured(search(0.3), AXIS, Unseen(0.02, std, 0.1, kept))


@pytest.mark.parametrize(
    ("size", "std", "counts"),
    [
        (0.14, 0.006, True),  # 4.4 standard deviations in the fitted logs, 7 in the held-out ones
        (0.14, 0.011, False),  # 4.4 and 3.8
        (0.1, 0.005, False),  # 2.7 and 8
    ],
)
def test_either_log_tells_it_beyond_any_chance_and_the_other_surely(size, std, counts):
    assert measured(search(size), AXIS, Unseen(0.02, std, 0.1, 0.9)) == counts


def test_an_error_needs_its_share_beside_what_stands_out():
    assert not measured(search(0.3, stands_out=True), AXIS, SEEN_AGAIN)


SPRING = Candidate("joint_spring", 2)


def _found(candidate: Candidate, energy: float) -> Any:
    return SimpleNamespace(candidate=candidate, excess=energy, gain=SimpleNamespace(energy=energy))


@pytest.mark.parametrize(
    ("unseen", "spring", "tie"),
    [
        (SEEN_AGAIN, 95.0, [AXIS, SPRING]),
        (SEEN_AGAIN, 130.0, [SPRING, AXIS]),
        (Unseen(0.02, 0.02, 0.1, 0.9), 95.0, [AXIS]),  # held-out logs do not show the spring
    ],
)
def test_an_error_is_in_a_tie_with_a_law_that_held_out_logs_show_too(unseen, spring, tie, monkeypatch):
    monkeypatch.setattr(wrong_description, "region_of", lambda *_: Region((1,)))
    held: Any = SimpleNamespace(share=lambda *_: unseen)
    errors = Step((_found(AXIS, 100.0),), 0.05, ())
    step = wrong_description._with_law(search(0.3), errors, _found(SPRING, spring), held)
    assert [f.candidate for f in step.tie] == tie


def test_a_law_alone_needs_its_share(monkeypatch):
    """What an error of the robot file counts by is not enough for a law."""
    monkeypatch.setattr(gate, "region_of", lambda *_: Region((1,)))
    monkeypatch.setattr(gate, "beyond_motion", lambda *_: False)
    monkeypatch.setattr(gate, "_over_floor", lambda *_: 1.1)
    monkeypatch.setattr(gate, "share_in", lambda *_: 0.01)
    held: Any = SimpleNamespace(share=lambda *_: SEEN_AGAIN, holds=lambda *_: True)
    view = search(0.3)
    view.p_value, view.rows, view.drives = lambda _: 0.01, lambda _: [1], lambda _: 0.0
    view.floor_energy_on = lambda _: 1.0
    reasons = [gate.admission(view, _found(c, 100.0), [c], held).reason for c in (AXIS, SPRING)]
    assert reasons == ["", "it takes 1 % of what exceeds the floor there"]


@pytest.mark.parametrize(("taken", "matters"), [(0.08, False), (0.12, True)])  # of a fifth of the floor
def test_where_nothing_exceeds_the_floor_held_out_logs_show_a_hundredth_of_the_error(
    taken, matters, monkeypatch
):
    monkeypatch.setattr(gate, "region_of", lambda *_: Region((1,)))
    monkeypatch.setattr(gate, "beyond_motion", lambda *_: False)
    monkeypatch.setattr(gate, "_over_floor", lambda *_: 1.1)
    monkeypatch.setattr(gate, "share_in", lambda *_: 1.0)
    monkeypatch.setattr(gate, "same_order", lambda *_: False)
    unseen = Unseen(taken, taken / 20, 0.0, 0.9)
    held: Any = SimpleNamespace(share=lambda *_: unseen, holds=lambda *_: True)
    view = search(0.3)
    view.p_value, view.rows, view.drives = lambda _: 0.01, lambda _: [1], lambda _: 0.0
    view.floor_energy_on = lambda _: 1.0
    reason = gate.admission(view, _found(SPRING, 100.0), [SPRING], held).reason
    assert reason == (
        "" if matters else f"on held-out data it takes {unseen}, too little beside the floor to matter"
    )


@pytest.mark.parametrize(("over", "named"), [(0.6, False), (0.8, True)])
@pytest.mark.parametrize("quiet", [0.1, 5.0])
def test_a_residual_far_below_its_floor_shows_no_law(over, named, quiet, monkeypatch):
    """Where the law takes, in the first of two bands; what is left in the other is
    no matter.
    """
    monkeypatch.setattr(gate, "region_of", lambda *_: Region((1,), (0, 1)))
    monkeypatch.setattr(gate, "beyond_motion", lambda *_: False)
    monkeypatch.setattr(gate, "share_in", lambda *_: 1.0)
    monkeypatch.setattr(gate, "_fall", lambda *_: np.array([[0.0, 0.0], [3.0, 0.0]]))
    held: Any = SimpleNamespace(share=lambda *_: None, holds=lambda *_: True)
    view = search(0.3)
    view.p_value, view.rows, view.drives = lambda _: 0.01, lambda _: [1], lambda _: 0.0
    view.floor_energy_on = lambda _: 1.0
    left = np.array([[[4.0, 4.0], [over**2 * 7.0, quiet * 7.0]]])
    view.examination.by_band = lambda _: left
    view.examination.replica_energy, view.examination.count = np.ones((3, 2, 2)), np.full(2, 7.0)
    reason = gate.admission(view, _found(SPRING, 100.0), [SPRING], held).reason
    assert (reason == "") == named
    assert named or reason.startswith("the residual lies below its floor there (0.6 times)")
