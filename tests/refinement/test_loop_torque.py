"""Torques that no log holds, from the robot's own loop: against the torque inside the FMU."""

from dataclasses import replace

import numpy as np
import pytest

import pyident as pi
from flexfmu.simulate import LoadedFmu
from flexmodels.coordinate import torque_of
from flexmodels.experiment import identification
from pyident.logs.log import Log, LogError
from pyident.refinement.loop_torque import with_loop_torque


@pytest.fixture(scope="module")
def recorded(four_link, four_link_fmu):
    """With noise on the encoders, which the controller reads."""
    with LoadedFmu(four_link_fmu) as fmu:
        noise = {name: 1e-6 for name in four_link.coordinates if name.endswith(".e")}
        frame = fmu.simulate_batch(identification(four_link), noise=noise, noise_seeds=[1])[0]
    return Log(frame, "recorded")


def _bare(log: Log, robot) -> Log:
    return replace(log, frame=log.frame.drop(columns=list(robot.torques)))


def test_the_controllers_answer_is_the_torque_in_the_fmu(four_link, recorded):
    (log,), notes = with_loop_torque(four_link, [_bare(recorded, four_link)])
    for name in four_link.torques:
        true = recorded.frame[name].to_numpy()
        off = log.frame[name].to_numpy() - true
        assert off.std() < 1e-6 * true.std(), name  # every sample, but for what the integral held
        assert np.abs(off.mean()) < 2e-3 * true.std(), name
    assert "no torque" in notes[0]


def test_identification_finds_the_same_without_torque(four_link, recorded):
    with_torque, without = (
        pi.identify(four_link, log, estimator="wls").robot.parameters
        for log in (recorded, _bare(recorded, four_link))
    )
    for k in range(1, 5):
        for name in (f"joint{k}.coulomb", f"joint{k}.viscous", f"joint{k}.k[1]"):
            assert without[name] == pytest.approx(with_torque[name], rel=0.01), name


def test_what_the_log_does_not_tell_is_said(four_link, recorded):
    bare = _bare(recorded, four_link)
    blind = replace(bare, frame=bare.frame.drop(columns="joint2.tau_ff"))
    with pytest.raises(LogError, match=r"neither torques nor joint2\.tau_ff"):
        with_loop_torque(four_link, [blind])
    rare = replace(bare, frame=bare.frame.iloc[::2].reset_index(drop=True))
    with pytest.raises(LogError, match=r"not those of the controller"):
        with_loop_torque(four_link, [rare])


def test_measured_torques_stay(four_link, recorded):
    some = replace(recorded, frame=recorded.frame.drop(columns=torque_of(2)))
    assert with_loop_torque(four_link, [recorded, some]) == ((recorded, some), ())
