"""What is named beside an error of a machine's description, or in its place: machines drawn at random."""

import pytest

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes this log and is not installed")
pytest.importorskip("mujoco", reason="MuJoCo moves this machine and is not installed")

from studies.bending_drives import study as bending_drives
from studies.foreign_logs import cases as foreign_logs
from studies.foreign_logs.generator import made
from studies.foreign_logs.methods import said_of


@pytest.mark.slow
def test_what_the_slope_of_a_large_bend_leaves_is_no_other_error():
    """A gear ratio of 0.07 % and a joint 0.8 mm off were named beside the drive."""
    case = bending_drives.case_list(2521, 48)[37]
    _, answer, _ = said_of(bending_drives.made(case))
    assert answer.ties == [[("drive_compliance", 3)]]


@pytest.mark.slow
def test_no_gear_ratio_is_named_beside_what_slow_noise_may_excuse():
    """A hose at a single joint was a gear ratio 0.9 % off, which took 40 % of it."""
    case = foreign_logs.case_list(2471, 120)[21]
    _, answer, _ = said_of(made(case))
    named = [effect for tie in answer.ties for effect, _ in tie]
    assert "gear_ratio" not in named
    assert answer.verdict != "nothing_detectable"
