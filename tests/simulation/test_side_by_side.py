"""Replicas that are simulated together against the same ones made one by one."""

import numpy as np
import pytest
from two_link_logs import loaded, two_link

from flexmodels.experiment import Experiment
from pyident.logs.log import Log
from pyident.simulation.replica import Repeat, side_by_side

NOISE = {"joint1.e": 2e-6, "joint2.e": 2e-6, "joint1.eps[1]": 1e-6, "joint2.tau": 0.01}
MAGNITUDES = {"e": 1.0, "eps[1]": 1e-3, "tau": 100.0}  # rad, rad, N m


def test_together_they_are_what_they_are_alone(tmp_path):
    robot, time = two_link(), np.arange(300) / 250
    swing = 0.3 * np.column_stack([1 - np.cos(3 * time), np.sin(4 * time) ** 2])
    plans = [Experiment(time[:n], swing[:n], 4 * swing[:n] ** 2) for n in (300, 250)]
    with loaded(robot, tmp_path) as fmu:
        repeats = [Repeat(Log(fmu.simulate(plan), f"log {n}"), plan) for n, plan in enumerate(plans)]
        wanted = [(r, seed) for seed in (3, 4) for r in repeats]
        together = side_by_side(fmu, wanted, robot.parameters, NOISE)
        alone = [r.replica(fmu.simulate, robot.parameters, NOISE, seed) for r, seed in wanted]
    for one, other in zip(together, alone, strict=True):
        assert one.source == other.source
        assert list(one.frame) == list(other.frame)
        for name, size in MAGNITUDES.items():
            column = f"joint2.{name}"
            expected = other.frame[column].to_numpy()
            assert one.frame[column].to_numpy() == pytest.approx(expected, abs=1e-9 * size), column
