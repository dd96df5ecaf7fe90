"""Laws with which a model follows logs that no simulation of it follows without."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from two_link_logs import hidden, loaded, made_log, two_link

from flexmodels.inputs import SimulationError
from pyident.diagnosis.base.residual_over_floor import examine
from pyident.diagnosis.base.setting import set_up, workers_of
from pyident.diagnosis.conclusion import conclusion
from pyident.diagnosis.rounds import laws_that_follow
from pyident.diagnosis.rounds.laws_that_follow import with_laws_that_follow
from pyident.diagnosis.search.search import search_of
from pyident.simulation.fmu_runs import runs_here


def by_noise(logs):
    """A search over the sensors' noise alone, as where no simulation of the fit follows."""
    setting = replace(set_up(two_link(), logs), unfollowed="it cannot be simulated")
    with workers_of(setting, runs_here) as workers:
        return search_of(examine(setting, workers, lambda _: None))


def logs_of(robot, folder):
    with loaded(robot, folder) as fmu:
        return [made_log(fmu, robot, seed) for seed in (1, 2, 3)]


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    *logs, heldout = logs_of(hidden(), tmp_path_factory.mktemp("one"))
    return by_noise(logs), [heldout]


def test_a_law_is_named_over_the_floors_of_a_model_that_has_it(one):
    search, heldout = one
    told: list[float] = []
    asked = with_laws_that_follow(search, heldout, runs_here, told.append)
    assert asked is not None
    over, held, selection = asked
    found = conclusion(over, selection, held, heldout)
    (finding,) = found.findings
    assert (finding.tie[0].effect, finding.tie[0].joint) == ("asymmetric_coulomb", "joint2")
    assert found.verdict == "missing_effect"
    assert finding.heldout_gain_percent is not None
    assert finding.heldout_gain_percent > 90
    assert found.notes[0].startswith("no simulation of the fitted model follows these logs; one with asym")
    assert not found.limits
    assert told == sorted(told)
    raised = over.examination.replica_energy.mean(axis=0) / search.examination.replica_energy.mean(axis=0)
    assert (raised >= 1 - 1e-9).all()


def test_what_takes_a_part_only_is_not_named(one, monkeypatch):
    """Though a model with it follows the logs."""
    monkeypatch.setattr(laws_that_follow, "take_all", lambda *_: False)
    monkeypatch.setattr(laws_that_follow, "_FIRST", 1)
    monkeypatch.setattr(laws_that_follow, "_TOGETHER", 1)
    assert with_laws_that_follow(one[0], one[1], runs_here, lambda _: None) is None


def test_a_second_law_and_another_first_one_are_tried_where_none_follows(one, monkeypatch):
    asked: list[list[tuple[str, int]]] = []

    def refused(_: Any, laws: Any, *__: Any) -> Any:
        asked.append([(law.effect, law.joint) for law in laws])
        raise SimulationError("run 0: friction chatters")

    search = one[0].resting_on(())
    loud = replace(search.examination, replica_energy=1e-3 * search.examination.replica_energy)
    monkeypatch.setattr(laws_that_follow, "replicated", refused)
    assert with_laws_that_follow(search_of(loud), one[1], runs_here, lambda _: None) is None
    assert [len(laws) for laws in asked] == [1, 2, 1, 2]
    assert asked[0] == asked[1][:1] == [("asymmetric_coulomb", 2)]
    assert asked[2] == asked[3][:1] != asked[0]
    assert len(set(asked[1])) == 2


def test_no_law_is_joined_where_nothing_stands_out_of_the_noise(tmp_path):
    """Nor is one named: the logs are of the robot as its file says."""
    search = by_noise(logs_of(two_link(), tmp_path)[:2])
    quiet = search.over_floor.max()
    assert np.isfinite(quiet)
    assert not search.stands_out
    assert with_laws_that_follow(search, [], runs_here, lambda _: None) is None
