"""Coefficients and ties of a law that is strong beside its floor."""

from dataclasses import replace
from pathlib import Path

import pytest
from two_link_logs import hidden, in_process, loaded, made_log, two_link

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.coefficients import gain_beside
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.searched import searched

LAW = Candidate("asymmetric_coulomb", 2)


def searched_with(folder: Path, louder: float) -> Search:
    with loaded(hidden(), folder) as fmu:
        logs = [made_log(fmu, hidden(), seed, louder=louder) for seed in range(2)]
    return searched(two_link(), logs, in_process)


@pytest.fixture(scope="module")
def search(tmp_path_factory) -> Search:
    return searched_with(tmp_path_factory.mktemp("coefficients"), 1.0)


@pytest.fixture(scope="module")
def noisier(tmp_path_factory) -> Search:
    """Where weights that start alike end at others, with a part of the law at the other joint."""
    return searched_with(tmp_path_factory.mktemp("noisier"), 3.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["search", "noisier"])
def test_a_law_is_missing_in_its_own_equation_alone(name, request):
    search = request.getfixturevalue(name)
    over = search.over_floor
    assert over[1] > 100
    assert (over[[0, *range(2, len(over))]] < 1.5).all()


def test_a_law_has_its_coefficients_within_their_deviations(search):
    """Two parts in a thousand are what friction that jumps between samples leaves."""
    found = gain_beside(search, [], LAW)
    assert (found.std < 0.01).all()
    for value, std, true in zip(found.coefficients, found.std, (2.5, 4.0), strict=True):
        assert abs(value - true) < 3 * std + 2e-3 * true


def test_another_law_in_the_base_leaves_them(search):
    found = gain_beside(search, [Candidate("stribeck", 1, (("velocity", 0.1),))], LAW)
    assert found.coefficients == pytest.approx([2.5, 4.0], rel=0.01)


def test_where_the_best_law_leaves_nothing_only_chance_ties_another_to_it(search):
    best = search.best("asymmetric_coulomb", 2)
    assert best is not None
    rival = replace(best, candidate=Candidate("viscous_drift", 2))
    near = replace(rival, gain=replace(best.gain, energy=best.gain.energy - 10))
    nearly = replace(rival, gain=replace(best.gain, energy=0.95 * best.gain.energy))
    assert near in search.led_by(best, [best, near]).tie
    assert nearly not in search.led_by(best, [best, nearly]).tie


def test_where_it_leaves_much_one_that_explains_nearly_as_much_is_tied(search):
    best = search.best("offset_drift", 2)
    assert best is not None
    beside = Candidate("viscous_drift", 2)
    rival = replace(best, candidate=beside, gain=replace(best.gain, energy=0.902 * best.gain.energy))
    assert 0.098 * best.gain.energy > search.rules.chance**2
    assert rival in search.led_by(best, [best, rival]).tie
