"""Two errors of the robot file that describe one robot are told together, and no motion is asked for."""

import pytest

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes this log and is not installed")
pytest.importorskip("mujoco", reason="MuJoCo moves this machine and is not installed")

from studies.foreign_logs.cases import case_list
from studies.foreign_logs.generator import made
from studies.foreign_logs.sensors import as_log

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


@pytest.mark.slow
def test_a_turned_frame_is_an_encoder_that_starts_elsewhere():
    """Joint 4 is turned about the axis of joint 3."""
    (case,) = [c for c in case_list(2221, 120) if c.id == "037"]
    drawn = made(case)
    fitted = [as_log(drawn.robot, drawn.fit, "fitted")]
    found = concluded(
        searched(drawn.robot, fitted, never), never, [as_log(drawn.robot, drawn.heldout, "held")]
    )
    (finding,) = found.findings
    values = {(n.effect, n.joint): n.values["correction"] for n in finding.tie}
    (truth,) = drawn.truth
    assert values.keys() == {("encoder_zero", "joint3"), ("axis[z]", "joint4")}
    assert values["axis[z]", "joint4"] == pytest.approx(truth.amount, rel=0.2)
    assert values["encoder_zero", "joint3"] == pytest.approx(-values["axis[z]", "joint4"], rel=0.05)
    assert finding.alike
    assert not finding.experiment
    assert found.verdict == "missing_effect"
    assert "which describe the same robot: correct one of them" in found.sentence
