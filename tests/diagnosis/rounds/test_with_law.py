"""Floors no lower than what replicas of a model with the first law leave."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from six_axis_logs import arm, made

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.rounds.replicas_with_laws import beside_laws, over_floors_of
from pyident.diagnosis.rounds.with_law import _leaves_nothing, beside_its_replicas
from pyident.diagnosis.search.search import search_of
from pyident.diagnosis.searched import searched


def never(_: Any) -> Any:
    raise AssertionError("nothing is simulated here")


@pytest.fixture(scope="module")
def examination():
    return searched(arm(), [made(arm(), 0, duration=20.0)], never).examination


def test_floors_rise_where_others_leave_more_and_fall_nowhere(examination):
    more = np.ones(examination.energy.shape)
    more[1, 2], more[3, 4] = 9.0, 0.25
    having = replace(examination, replica_energy=examination.replica_energy * more)
    over = over_floors_of(examination, having)
    rise = over.replica_energy.mean(axis=0) / examination.replica_energy.mean(axis=0)
    assert rise[1, 2] == pytest.approx(9.0)
    rise[1, 2] = 1.0
    assert rise == pytest.approx(np.ones_like(rise))
    before, after = (np.square(ex.replica_residuals[0][0][1]) for ex in (examination, over))
    inside = examination.bands[0][:, 2] > 0
    assert after[inside] == pytest.approx(9.0 * before[inside])
    assert after[~inside] == pytest.approx(before[~inside])


def test_floors_of_another_unit_are_taken_in_their_own(examination):
    coarse = [replace(floor, rms=3.0 * floor.rms) for floor in examination.floors]
    having = replace(examination, floors=coarse, replica_energy=examination.replica_energy / 9.0)
    over = over_floors_of(examination, having)
    assert over.replica_energy == pytest.approx(examination.replica_energy)


def test_where_nothing_is_left_replicas_with_the_law_are_not_made(monkeypatch):
    """Nothing stands out, and what is named besides takes all that is missing there; or only a part of it."""
    steps = [_step("backlash", 1), _step("stribeck", 2)]
    search: Any = SimpleNamespace(
        examination=SimpleNamespace(setting=SimpleNamespace(follows=True)),
        rules=SimpleNamespace(whole=0.95, part=0.1),
        resting_on=lambda _: SimpleNamespace(stands_out=False),
    )
    before: Any = search, None, _selected(steps)
    monkeypatch.setattr("pyident.diagnosis.rounds.asked.region_of", lambda *_: None)
    monkeypatch.setattr("pyident.diagnosis.rounds.asked.share_in", lambda *_: 0.99)
    assert beside_its_replicas(before, never, lambda _: None) is before
    monkeypatch.setattr("pyident.diagnosis.rounds.asked.share_in", lambda *_: 0.5)
    with pytest.raises(AttributeError):  # it sets out to make them
        beside_its_replicas(before, never, lambda _: None)


def _step(effect: str, joint: int) -> Any:
    lead = Candidate(effect, joint)
    return SimpleNamespace(best=SimpleNamespace(candidate=lead), candidates=[lead])


@pytest.mark.parametrize("follows", [True, False])
def test_what_cannot_be_asked_again_stays(follows):
    """An error of the description is no law of a model; without a simulation there are no replicas."""
    step = _step("torque_gain" if follows else "backlash", 1)
    setting = SimpleNamespace(follows=follows)
    search: Any = SimpleNamespace(
        examination=SimpleNamespace(setting=setting), rules=SimpleNamespace(part=0.1)
    )
    asked: Any = search, None, _selected((step, step))
    assert beside_its_replicas(asked, never, lambda _: None) is asked


def test_a_law_leaves_nothing_where_replicas_that_have_it_leave_as_much(examination):
    """No more, and not far less either: floors that are too high hide whatever is there."""
    everywhere = np.ones(len(examination.energy), bool)
    each = np.broadcast_to(examination.energy, (20, 6, 7))
    assert _leaves_nothing(replace(examination, replica_energy=each), everywhere, set())
    gain = Candidate("torque_gain", 1).family  # of the robot file: no law of a model
    assert not _leaves_nothing(replace(examination, replica_energy=each), everywhere, {gain})
    assert not _leaves_nothing(replace(examination, replica_energy=each / 9.0), everywhere, set())
    hiding = replace(examination, replica_energy=9.0 * each)
    assert not _leaves_nothing(hiding, everywhere, set())
    assert _leaves_nothing(hiding, ~everywhere, set())


def test_beside_a_law_a_residual_is_as_many_floors_as_in_the_model_that_has_it(examination):
    """Its values may be off in a regression, and leave what a fit by simulation does not."""
    law = Candidate("viscous_drift", 1, (("settling", 10.0),))
    having = replace(examination, replica_energy=np.broadcast_to(examination.energy, (20, 6, 7)) / 1.2)
    off = replace(examination, replica_energy=examination.replica_energy / 9.0)
    beside = search_of(off).resting_on([law])
    over = beside_laws(off, [law], having)
    ratio = over.by_band(beside.base.residual).sum(axis=0) / (over.replica_energy.mean(axis=0) * over.count)
    known = over.count > 0
    assert ratio[:, known].max() == pytest.approx(1.2)  # floors only rise: where less was left, it still is
    assert np.median(ratio[:, known]) == pytest.approx(1.2)


def _selected(steps: Sequence[Any]) -> Any:
    return SimpleNamespace(steps=steps, candidates=[], refusals=(), first=SimpleNamespace(ranked=()))
