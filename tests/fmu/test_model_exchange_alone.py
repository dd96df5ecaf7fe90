"""FMUs that have model exchange only, as other tools write them."""

import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest
from one_joint import one_joint

import pyident as pi
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment

INERTIA, DAMPING = 0.7 + 0.6, 0.5  # motor and link [kg m²], [N m s/rad]
TORQUE, RISE, SPEED = 2.0, 5.0, 0.5  # [N m], [N m/s], [rad/s]


def without_co_simulation(fmu, path):
    with zipfile.ZipFile(fmu) as full, zipfile.ZipFile(path, "w") as bare:
        for name in full.namelist():
            content = full.read(name)
            if name == "modelDescription.xml":
                root = ElementTree.fromstring(content)
                part = root.find("CoSimulation")
                assert part is not None
                root.remove(part)
                content = ElementTree.tostring(root)
            bare.writestr(name, content)
    return path


def turned(t):
    """J dv/dt = a + b t - d v from v(0), integrated twice."""
    steady, slope, rate = TORQUE / DAMPING - RISE * INERTIA / DAMPING**2, RISE / DAMPING, DAMPING / INERTIA
    return steady * t + slope * t**2 / 2 + (SPEED - steady) * (1 - np.exp(-rate * t)) / rate


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_rising_torque_turns_a_hinge_as_the_closed_form_says(fmi, tmp_path):
    """Inputs are linear between samples; held ones would be 5e-4 rad off."""
    full = pi.export_fmu(one_joint(), tmp_path / "plant.fmu", fmi=fmi, part="plant")
    time = np.arange(26) * 0.04
    torque = (TORQUE + RISE * time)[:, None]
    starts = {"joint1.coulomb": 0.0, "joint1.J_m": 0.7, "joint1.viscous": DAMPING, "joint1.de_0": SPEED}
    with LoadedFmu(without_co_simulation(full, tmp_path / "bare.fmu")) as fmu:
        log = fmu.simulate(Experiment(time, 0 * torque, torque), starts)
    np.testing.assert_allclose(log["joint1.e"], turned(time), rtol=0, atol=1e-6)
    np.testing.assert_array_equal(log["joint1.tau"], torque[:, 0])
