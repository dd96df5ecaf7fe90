"""A replica along a measured motion that begins in motion: inverse dynamics in closed form is the oracle."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.mechanics.plant import equations
from pyident.logs.log import Log
from pyident.simulation.replica import repeats

INERTIA, COULOMB, VISCOUS, OMEGA = 1.1, 1.0, 2.0, 3.0


def swinging(phase: float, noise: float = 0.0) -> Log:
    """The arm of `one_joint` on a sine, whose torque is known."""
    time = np.arange(500) * 0.004
    angle = OMEGA * time + phase
    q, v, a = np.sin(angle), OMEGA * np.cos(angle), -(OMEGA**2) * np.sin(angle)
    tau = INERTIA * a + COULOMB * np.sign(v) + VISCOUS * v
    q = q + noise * np.random.default_rng(1).standard_normal(len(q))
    return Log(pd.DataFrame({"time": time, "joint1.e": q, "joint1.tau": tau}), "swing")


@pytest.mark.parametrize("phase", [0.0, 0.7, 2.5])
def test_it_sets_out_with_the_speed_of_the_log(tmp_path, phase):
    robot, log = replace(one_joint(), controller=None), swinging(phase)
    simulated, (again,) = repeats(robot, [log])
    path = export_fmu(equations(simulated), tmp_path / "robot.fmu")
    measured = log.frame["joint1.tau"]
    jolts = []
    with LoadedFmu(path) as fmu:
        for plan in (again.plan, replace(again.plan, speed=None)):
            missed = (fmu.simulate(plan)["joint1.tau"] - measured).abs()
            jolts.append(missed[:50].max())
    assert jolts[0] < 0.05 * measured.abs().max() < jolts[1] / 5


@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-4])
@pytest.mark.parametrize("phase", [0.0, 0.7, 2.5])
def test_its_speed_is_that_of_the_first_sample(phase, noise):
    (again,) = repeats(replace(one_joint(), controller=None), [swinging(phase, noise)])[1]
    assert again.plan.speed == pytest.approx([OMEGA * np.cos(phase)], rel=0.02)


def test_from_rest_it_sets_out_at_rest():
    robot = replace(one_joint(), controller=None)
    log = swinging(np.pi / 2)
    (again,) = repeats(robot, [log])[1]
    assert (again.plan.speed == 0).all()
