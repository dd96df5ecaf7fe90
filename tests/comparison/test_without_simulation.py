"""A model that cannot be simulated is still compared: its equations against their own definition."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from one_joint import one_joint

import pyident as pi
from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from pyident.comparison.compare import compare
from pyident.simulation.simulator import Unsimulated
from pyident.verbs.judged import Compared, side_by_side

TURN = 2 * np.pi


class Refusing:
    """Workers whose simulator refuses."""

    def __init__(self, robot):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def submit(self, work, *arguments):
        work(Unsimulated(), *arguments)


REFUSING: Any = Refusing


@pytest.fixture(scope="module")
def log():
    time = np.arange(2001) * 0.004
    reference = (1 - np.cos(TURN * time))[:, None]
    return pi.simulate(one_joint(), Experiment(time, reference, np.zeros_like(reference)))


def test_its_equations_are_compared_without_a_floor(log, tmp_path):
    viscous = one_joint().parameters["joint1.viscous"]
    wrong = one_joint().with_parameters({"joint1.viscous": 2 * viscous})
    found = compare(wrong, [replace(log, source="/a/folder/monday.parquet")], REFUSING, lambda _: None)
    assert found.sentence.endswith("torque in monday.parquet.")
    error = found.logs[0].equations["joint1.e"]
    speed = np.gradient(log.frame["joint1.e"], 0.004)
    assert error.rmse == pytest.approx(viscous * np.sqrt(np.mean(speed**2)), rel=0.05)
    assert np.isnan(error.floor)
    assert "cannot be simulated" in found.sentence
    assert not found.logs[0].simulation
    told = json.dumps(found.json(), allow_nan=False)
    assert '"floor_percent": null' in told
    page = Compared(found, ()).save(tmp_path / "page.html").read_text()
    assert "cannot be simulated" in page


def test_it_stands_beside_one_that_can(log):
    bad = compare(one_joint(), [log], REFUSING, lambda _: None)
    text = str(side_by_side(["bad", "good"], [Compared(bad, ()), pi.compare(one_joint(), log)]))
    rows = [line.split() for line in text.splitlines() if " rad " in line]
    assert [row[2:5] for row in rows] == [["-", "-", "-"]]


def test_a_simulator_that_refuses_says_so():
    with pytest.raises(SimulationError):
        Unsimulated().simulate()


def test_what_would_explain_it_is_not_asked(log, monkeypatch):
    from pyident.verbs import judge

    monkeypatch.setattr(judge, "FmuRuns", Refusing)
    with pytest.raises(SimulationError, match="cannot be simulated"):
        pi.explain(one_joint(), log)
