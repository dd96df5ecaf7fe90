"""Logs of other simulators: nothing hidden is nothing found, and what is hidden is named.

The cases in `foreign` were made by simulators that share no code with this project, and were looked at while
the diagnosis was built: that they come out right is a floor, not a score.
"""

import pytest

from flexmodels.files.robot_file import load_robot
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.searched import searched
from pyident.logs.log import read_log
from pyident.simulation.fmu_runs import FmuRuns


def diagnosed(robot, logs) -> Diagnosis:
    """The last log is held out."""
    return concluded(searched(robot, logs[:-1], FmuRuns), FmuRuns, logs[-1:])


@pytest.fixture
def foreign(data):
    """Reads the logs of a case."""

    def read(case: str, *names: str):
        folder = data / "foreign" / case
        if not folder.is_dir():
            pytest.skip(f"measured data of {folder} are not here")
        return [read_log(folder / f"{name}.parquet") for name in names]

    return read


@pytest.mark.slow
def test_nothing_is_hidden_in_the_scara(foreign, data):
    robot = load_robot(data / "foreign" / "null_scara" / "scara.toml")
    found = diagnosed(robot, foreign("null_scara", "a", "b", "c"))
    assert found.verdict == "nothing_detectable", found.sentence


@pytest.mark.slow
def test_nothing_is_hidden_in_the_flexible_arm_without_noise(foreign):
    """Its simulator rounds friction near rest and integrates otherwise: 0.01 to 0.3 % of the torque."""
    found = diagnosed(load_robot("four_link"), foreign("null_four_link", "paper", "slow", "fast"))
    assert found.verdict == "nothing_detectable", found.sentence


@pytest.mark.slow
def test_presliding_of_another_form_is_named(foreign):
    found = diagnosed(load_robot("four_link"), foreign("presliding_four_link", "a", "b", "c"))
    assert found.verdict == "missing_effect", found.sentence
    assert [(n.effect, n.joint) for f in found.findings for n in f.tie] == [("presliding", "joint1")]
