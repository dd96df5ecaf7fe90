"""Experiments by name and from files."""

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint

from flexmodels.experiment import identification
from pyident.simulation.references import ExperimentError, load_experiment, read_experiment

FRAME = pd.DataFrame(
    {"time": 5 + 0.01 * np.arange(50), "joint1.r": np.sin(np.arange(50.0)), "joint1.tau_ff": np.arange(50.0)}
)


def test_a_file_starts_at_zero_and_keeps_its_columns(tmp_path):
    FRAME.to_csv(tmp_path / "plan.csv", index=False)
    plan = read_experiment(str(tmp_path / "plan.csv"), 1)
    assert plan.time[0] == 0.0
    assert plan.time[-1] == pytest.approx(0.49)
    assert plan.reference[:, 0] == pytest.approx(FRAME["joint1.r"])
    assert plan.feedforward[:, 0] == pytest.approx(FRAME["joint1.tau_ff"])


def test_a_file_without_references_says_which(tmp_path):
    FRAME.drop(columns="joint1.r").to_csv(tmp_path / "plan.csv", index=False)
    with pytest.raises(ExperimentError, match=r"joint1\.r is missing"):
        read_experiment(str(tmp_path / "plan.csv"), 1)


def test_names(tmp_path):
    robot = one_joint()
    plan = load_experiment(robot, "identification")
    assert plan.reference == pytest.approx(identification(robot).reference)
    with pytest.raises(ExperimentError, match="experiments by name: identification, line"):
        load_experiment(robot, str(tmp_path / "nothing.csv"))
