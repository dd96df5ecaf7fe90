"""What must stay: an arm that sticks, the energy of one without losses; and a push in closed form."""

import warnings

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

import pyident as pi
from flexfmu.foreign.interface import Interface
from flexfmu.foreign.model import FmuModel
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment

FORCE = 1000.0  # [N]
ROUNDING: dict[Interface, float] = {"CoSimulation": 1e-12, "ModelExchange": 1e-8}  # [m] that of CVode
MASS = 100.0  # [kg] of the carriage in emps.toml, before identification, without friction


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("fmi", [2, 3])
def test_a_stuck_arm_under_gravity_stays(fmus, four_link, fmi, interface):
    """60 s, controller gains off, gravity carried by the integral less what dry friction holds."""
    off = {f"joint{k}.{gain}": 0.0 for k in range(1, 5) for gain in ("Kp", "Kd", "Ki")}
    names = [f"joint{k}.e" for k in range(1, 5)]
    pose = {f"joint{k}.r": r for k, r in zip(range(1, 5), (0.0, 1.2, -0.5, 0.0), strict=True)}
    push = {f"joint{k}.tau_ff": t for k, t in zip(range(1, 5), (29.9, -44.9, 17.9, -7.9), strict=True)}
    result = simulate_fmu(
        str(fmus[fmi]),
        fmi_type=interface,
        stop_time=60.0,
        output_interval=0.1,
        start_values=off | pose | push,
        relative_tolerance=1e-8,
        output=names,
    )
    drift = np.column_stack([result[n] for n in names]) - list(pose.values())
    assert np.abs(drift).max() < 1e-9


def test_energy_is_kept_without_losses(four_link, fmus):
    """Friction, damping and controller off: the swinging arm keeps its energy over 10 s."""
    lossy = ("coulomb", "viscous", "d[1]", "d[2]", "d[3]")
    off = {n: 0.0 for n in four_link.parameters if n.endswith(lossy)}
    off |= {f"joint{k}.{gain}": 0.0 for k in range(1, 5) for gain in ("Kp", "Kd", "Ki")}
    time = np.arange(2501) * 0.004
    pose = np.tile([0.3, np.pi - 0.1, 0.1, 0.2], (len(time), 1))  # hanging
    speeds = tuple(n.replace(".e", ".de", 1) for n in four_link.coordinates)
    push = np.zeros_like(pose)
    push[1:50] = [20.0, 30.0, 10.0, 5.0]
    with LoadedFmu(fmus[2]) as fmu:
        log = fmu.simulate(Experiment(time, pose, push), off, outputs=speeds)
    energy = total_energy(four_link, log, speeds)
    assert np.abs(log["joint1.e"]).max() > 1.0
    assert np.ptp(energy) / np.abs(energy).max() < 1e-6


def total_energy(robot, log, speeds):
    """Kinetic, elastic and potential energy minus the work of the torques, by Pinocchio."""
    pinocchio_model = pytest.importorskip("pinocchio_model", reason="Pinocchio is not installed")
    oracle = pinocchio_model.PinocchioRobot(robot)
    q, v = log[list(robot.coordinates)].to_numpy(), log[list(speeds)].to_numpy()
    armature = np.r_[[robot.parameters[f"joint{k}.J_m"] for k in range(1, 5)], np.zeros(12)]
    stiffness = np.array([robot.parameters[n.replace("eps", "k")] for n in robot.coordinates[4:]])
    kinetic = [0.5 * b @ (oracle.mass_matrix(a) + np.diag(armature)) @ b for a, b in zip(q, v, strict=True)]
    elastic = 0.5 * (q[:, 4:] ** 2 @ stiffness)
    potential = [oracle.potential_energy(a) for a in q]
    tau = log[[f"joint{k}.tau" for k in range(1, 5)]].to_numpy()
    work = np.concatenate([[0.0], np.cumsum((tau[:-1] * np.diff(q[:, :4], axis=0)).sum(axis=1))])
    return np.array(kinetic) + elastic + np.array(potential) - work


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_plant_alone_under_constant_force(fmi, tmp_path):
    """A carriage without a controller: valid, with its recorded run; e = F t²/2m in both interfaces."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        path = pi.export_fmu("emps", tmp_path / "emps.fmu", fmi=fmi, part="plant")
    assert validate_fmu(str(path)) == []
    time = 0.004 * np.arange(101)
    for interface, rounding in ROUNDING.items():
        with FmuModel(path, interface) as fmu:
            e = fmu.run(time, {"joint1.tau": np.full(101, FORCE)}, [{}], ["joint1.e"])[0, :, 0]
        np.testing.assert_allclose(e, FORCE * time**2 / (2 * MASS), rtol=0, atol=rounding)
