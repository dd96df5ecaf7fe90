"""How the benchmark's model is chosen: the rule itself, and a drift that only the right law extrapolates."""

import numpy as np
import pandas as pd
import pytest
from pyident.sweep.studies.emps.benchmark import Judged, folds, simplest  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.emps.structures import STRUCTURES, fit, parts_of, rms  # pyright: ignore[reportMissingImports]

from flexmodels.files.robot_file import load_robot
from pyident.logs.log import Log
from pyident.simulation.free_run import plant_of, run_freely

AXIS = load_robot("emps")
BY_NAME = {s.name: s for s in STRUCTURES}


def judged(name, *heldout):
    return Judged(BY_NAME[name], AXIS, 0.0, heldout)


def test_the_simplest_within_a_standard_error_of_the_best_is_taken():
    best = judged("directional, warming", 0.8, 1.0, 1.2)  # 1.0, standard error 0.115
    near, far = judged("directional", 1.1, 1.1, 1.1), judged("symmetric", 1.2, 1.2, 1.2)
    assert simplest([best, near, far]) is near
    assert simplest([best, far]) is best


def test_no_part_is_judged_by_itself():
    for fitted, (first, last) in folds(1001):
        for a, b in fitted:
            assert b <= first or a >= last
    assert sorted(part for _, part in folds(1001)[2:]) == [(0, 250), (250, 500), (500, 750), (750, 1001)]


def made(robot, N=6000, step=2e-3):
    """Pushed to and fro, longer one way, by a simulation of the axis itself."""
    time = np.arange(N) * step
    torque = 45.0 * np.sign(np.sin(2 * np.pi * time / 2.3)) + 8.0 * np.sin(2 * np.pi * time / 0.9)
    torque[:20] = 0.0
    frame = pd.DataFrame({"time": time, "joint1.e": np.zeros(N), "joint1.tau": torque})
    return run_freely(robot, Log(frame, "start"))


def test_a_drift_is_found_in_one_half_and_predicts_the_other():
    truth = {
        "link1.m": 90.0, "joint1.viscous": 190.0, "joint1.coulomb": 20.0, "joint1.offset": -0.5,
        "joint1.asymmetric_coulomb.viscous": -30.0, "joint1.directional_drift.drift": -1.0,
    }  # fmt: skip
    warming, still = BY_NAME["directional, warming"], BY_NAME["directional"]
    log = made(warming.of(AXIS).with_parameters(truth))
    near = {
        name: 1.03 * truth[name] for name in ("link1.m", "joint1.viscous", "joint1.coulomb", "joint1.offset")
    }
    errors = {}
    for structure in (warming, still):
        robot = structure.of(AXIS.with_parameters(near))
        with plant_of(robot) as plant:
            values = fit(structure, robot, parts_of(robot, log, [(0, 3000)]), plant)
            errors[structure.name] = rms(robot, values, parts_of(robot, log, [(3000, 6000)]), plant)
        if structure is warming:
            assert values["joint1.directional_drift.drift"] == pytest.approx(-1.0, abs=0.05)
    assert errors[warming.name] < 0.1
    assert errors[still.name] > 10 * errors[warming.name]
