"""Constant torques that the model lacks: at more joints than four, drifting, and beside another law."""

import numpy as np
import pytest
from studies.foreign_logs.cases import case_list
from studies.foreign_logs.generator import made
from studies.foreign_logs.sensors import as_log

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import FmuRuns

SHARES = np.array([0.2, -0.3, 0.1, -0.2, 0.3])  # of the torques' standard deviations


@pytest.fixture(scope="module")
def arm():
    """A rigid arm of five joints with nothing hidden: the robot file, a log and a held-out one."""
    case = next(c for c in case_list(2140, 60) if c.id == "056")
    m = made(case, 7)
    assert len(m.robot.joints) == 5
    assert not m.truth
    robot = m.robot.without_effect("offset")
    return robot, as_log(m.robot, m.fit, "fit"), as_log(m.robot, m.heldout, "held out")


def with_constants(log: Log, sizes: np.ndarray, drifts: bool = False) -> Log:
    frame = log.frame.copy()
    for k, size in enumerate(sizes, start=1):
        frame[f"joint{k}.tau"] += size * (frame["time"] if drifts else 1)
    return Log.from_frame(frame, log.source)


def deviations(log: Log) -> np.ndarray:
    return np.array([log.frame[f"joint{k}.tau"].std() for k in range(1, 6)])


@pytest.mark.slow
def test_every_joint_may_have_an_offset(arm):
    robot, fit, held = arm
    sizes = SHARES * deviations(fit)
    search = searched(robot, [with_constants(fit, sizes)], FmuRuns)
    found = concluded(search, FmuRuns, [with_constants(held, sizes)])
    first = {f.tie[0].joint: f.tie[0] for f in found.findings}
    assert {name.effect for name in first.values()} == {"offset"}
    assert sorted(first) == [f"joint{k}" for k in range(1, 6)]
    for k, size in enumerate(sizes, start=1):
        assert first[f"joint{k}"].values["offset"] == pytest.approx(size, rel=0.1)
    rivals = {name.effect for f in found.findings for name in f.tie[1:]}
    assert "joint_spring" not in rivals  # with its preload it is an offset and more


def test_a_drift_of_the_zero_is_no_spring(arm):
    robot, fit, held = arm
    sizes = 0.05 * deviations(fit) / fit.frame["time"].iloc[-1] * np.array([1, 0, 1, 0, 0])
    search = searched(robot, [with_constants(fit, sizes, drifts=True)], FmuRuns)
    found = concluded(search, FmuRuns, [with_constants(held, sizes, drifts=True)])
    first = {(f.tie[0].effect, f.tie[0].joint) for f in found.findings}
    assert first == {("offset_drift", "joint1"), ("offset_drift", "joint3")}


@pytest.mark.slow
def test_zeros_that_move_from_log_to_log_are_told_and_nothing_is_missing(arm):
    robot, fit, held = arm
    sizes, half = SHARES * deviations(fit), len(fit) // 2
    parts = [fit.frame.iloc[:half], fit.frame.iloc[half:].reset_index(drop=True)]
    begun = [Log.from_frame(part.assign(time=fit.frame["time"][: len(part)]), "part") for part in parts]
    logs = [with_constants(log, way * sizes) for log, way in zip(begun, (1, -1), strict=True)]
    search = searched(robot, logs, FmuRuns)
    found = concluded(search, FmuRuns, [with_constants(held, 2 * sizes)])
    assert found.sentence.startswith("The zero of the torque of joints 1, 2, 3, 4 and 5 differs")
    assert not found.findings
    for k, size in enumerate(sizes, start=1):
        told = float(found.notes[0].split(f"joint{k}.offset by ")[1].split()[0])
        assert told == pytest.approx(-2 * size, rel=0.1)
