"""A loop answers a fast ripple the less the faster the joint turns: another log shows its order alone."""

from functools import cache

import pytest

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes this log and is not installed")
pytest.importorskip("mujoco", reason="MuJoCo moves this machine and is not installed")

from studies.foreign_logs.cases import case_list
from studies.foreign_logs.generator import made
from studies.foreign_logs.sensors import as_log

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.search.held_out import HeldOut, held_out
from pyident.diagnosis.search.same_order import same_order
from pyident.diagnosis.searched import searched


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


@cache
def ripple_in_a_loop():
    (case,) = [c for c in case_list(2272, 120) if c.id == "003"]
    drawn = made(case)
    fitted, held = ([as_log(drawn.robot, log, "log")] for log in (drawn.fit, drawn.heldout))
    return searched(drawn.robot, fitted, never).resting_on(()), held


def test_it_keeps_its_name_by_its_order():
    search, held = ripple_in_a_loop()
    found = concluded(search, never, held)
    (finding,) = [f for f in found.findings if f.tie[0].effect == "torque_ripple"]
    assert finding.tie[0].joint == "joint1"
    assert finding.heldout_gain_percent is not None
    assert finding.heldout_gain_percent < 50 < finding.share_percent
    assert any("show the same order, with another size" in note for note in found.notes)


def test_another_order_is_not_there():
    search, logs = ripple_in_a_loop()
    held = held_out(search, logs)
    found = search.best("torque_ripple", 1)
    assert found is not None
    order = dict(found.candidate.values)["order"]
    assert same_order(search, found.candidate, held)
    assert not same_order(search, found.candidate.at({"order": 1.15 * order}), held)
    assert not same_order(search, found.candidate, HeldOut(()))
    friction = search.best("position_dependent_friction", 1)
    assert friction is not None
    assert not same_order(search, friction.candidate, held)
