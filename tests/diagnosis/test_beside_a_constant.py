"""A law at a joint whose torque has a zero that the file does not know, far larger than the law."""

import numpy as np
from six_axis_logs import arm, made, plain
from two_link_logs import in_process

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched

ZERO, LEVEL, SPEED = 150.0, 2.0, 0.08  # N m, N m, rad/s


def rubbing(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """More friction near rest at joint 2, of other form than the catalogue's."""
    out = plain(q, v, load, time)
    out[:, 1] += ZERO + LEVEL * np.sign(v[:, 1]) / (1 + (v[:, 1] / SPEED) ** 2)
    return out


def test_both_are_named():
    robot = arm().without_effect("offset")
    logs = [made(robot, seed, rubbing) for seed in (1, 2)]
    said = concluded(searched(robot, logs[:1], in_process), in_process, logs[1:])
    values = {(f.tie[0].effect, f.tie[0].joint): f.tie[0].values for f in said.findings}
    assert values.keys() == {("offset", "joint2"), ("stribeck", "joint2")}
    assert abs(values["offset", "joint2"]["offset"] - ZERO) < 0.5
