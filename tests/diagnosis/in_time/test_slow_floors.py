"""A floor that has something slow for noise is told; a white one is not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from six_axis_logs import arm, made

from pyident.diagnosis.conclusion import conclusion
from pyident.diagnosis.result import Place
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.search.selection import Selection
from pyident.diagnosis.searched import searched
from pyident.diagnosis.unexplained.slow_floors import of_slow_floors, slow_floors


def never(_):
    raise AssertionError("nothing is simulated here")


@pytest.fixture(scope="module")
def search():
    return searched(arm(), [made(arm(), 0, duration=20.0)], never).resting_on(())


def place(joint: str, state: Any = "in_order") -> Place:
    return Place(joint, "motor", state, (1.0, 1.0), 1.0, "", None)


def slowly(search, row: int, times: float):
    """The search with more of what is left below half a hertz on an equation."""
    (left,), (log,) = search.base.residual, search.examination.logs
    more = np.where(np.tile(log.band.frequencies < 0.5, 2), times, 1.0)
    grown = left.copy()
    grown[row] *= more
    return replace(search, base=replace(search.base, residual=[grown]))


def test_a_slow_rest_is_told_where_nothing_exceeds_its_floor(search):
    slow = slowly(search, 2, 100.0)
    assert list(slow_floors(slow, [place("joint2"), place("joint3")])) == ["joint3"]
    assert not slow_floors(slow, [place("joint3", "unexplained")])
    (said,) = of_slow_floors(slow_floors(slow, [place("joint3")]))
    assert "times at joint3 what it is above 2 Hz" in said


def test_nothing_is_told_of_steady_noise(search):
    assert not slow_floors(search, [place(f"joint{k}") for k in range(1, 6)])
    assert list(of_slow_floors({})) == []


def test_a_verdict_of_nothing_names_the_joints_of_which_that_is_true(search):
    slow = slowly(search, 2, 100.0)
    calm = replace(slow.examination, base=slow.base, replica_energy=1e4 * slow.examination.replica_energy)
    whole = replace(slow, examination=calm).resting_on(())
    found = conclusion(whole, Selection((), whole.step(), {}), held_out(whole, []), [])
    assert found.verdict == "nothing_detectable"
    assert "at joint3 they do not tell it from slow noise" in found.sentence


def test_a_verdict_of_nothing_has_what_the_robot_file_may_have_wrong(search):
    """It is a note where it takes too little for a name; nobody reads notes below 'nothing is missing'."""
    note = "the robot file may be wrong in joint2.torque_gain (by about 0.06): it takes 90 % of what exceeds"
    calm = replace(search.examination, replica_energy=1e4 * search.examination.replica_energy)
    whole = replace(search, examination=calm).resting_on(())
    selection = Selection((), whole.step(), {}, notes=(note,))
    found = conclusion(whole, selection, held_out(whole, []), [])
    assert found.sentence.endswith("And the robot file may be wrong in joint2.torque_gain (by about 0.06).")
    assert note in found.notes
