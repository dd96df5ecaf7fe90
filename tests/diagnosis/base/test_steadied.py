"""A fit that cannot be simulated, because what the model lacks has bent it, is made one that can be."""

from typing import Any

import numpy as np
import pytest

from flexmodels.experiment import line
from flexmodels.files.robot_file import load_robot
from flexmodels.inputs import SimulationError
from pyident.diagnosis.base.setting import Setting, steadied
from pyident.simulation.fmu_runs import fmu_here


def test_a_hinge_without_spring_gets_a_tenth_of_its_middle_one_and_damping_with_it():
    robot = load_robot("four_link")
    before = robot.parameters
    soft = robot.with_parameters({"joint4.k[1]": 1e-8, "joint4.d[1]": 0.0})
    none: Any = None
    setting = steadied(Setting(soft, soft, (), {}, none, none))
    values = setting.simulated.parameters
    middle = np.median([1e-8, before["joint4.k[2]"], before["joint4.k[3]"]])
    assert values["joint4.k[1]"] == pytest.approx(0.1 * middle)
    assert values["joint4.d[1]"] > 0
    others = [n for n in before if ".k[" in n and n != "joint4.k[1]"]
    assert {n: values[n] for n in others} == {n: before[n] for n in others}
    motion = line(robot)
    with fmu_here(robot) as fmu:
        with pytest.raises(SimulationError, match="equilibrium"):
            fmu.simulate(motion, soft.parameters)
        assert len(fmu.simulate(motion, values | dict(setting.solver)))
