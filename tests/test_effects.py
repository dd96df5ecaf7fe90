"""Every law of the catalogue: inside the FMU and as columns of Φ, and what it does to the motion."""

from pathlib import Path

import numpy as np
import pytest

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.effects import CATALOGUE
from flexmodels.experiment import Experiment
from flexmodels.plant import equations
from flexmodels.robot import Robot, RobotError
from flexmodels.robot_file import load_robot, save_robot
from pyident.law_columns import coverage, effect_columns, nonlinear_grid
from pyident.motion import Motion
from pyident.regressor import regressor

TWO_LINK = Path(__file__).parent / "robots" / "two_link.toml"
STEP = 0.0005  # of the logs [s]; the controller's is 0.004
STRONG: dict[str, dict[str, float]] = {
    "stribeck": {"level": 10.0, "velocity": 0.2},
    "asymmetric_coulomb": {"coulomb": 5.0, "viscous": 3.0},
    "load_dependent_friction": {"coefficient": 0.3},
    "presliding": {"level": 15.0, "travel": 0.01},
    "nonlinear_viscous": {"quadratic": 8.0},
    "position_dependent_friction": {"cosine": 6.0, "sine": 4.0, "order": 3.0},
    "viscous_drift": {"drift": 6.0},
    "hardening_stiffness": {"cubic": 3e10},
    "backlash": {"stiffness": 6e4, "gap": 3e-4},
    "transmission_hysteresis": {"level": 10.0, "travel": 3e-4},
    "stiffness_coupling": {"k12": 4e4, "k13": -3e4, "k23": 5e4},
    "kinematic_error": {"cosine": 12.0, "sine": -9.0, "order": 4.0},
    "torque_ripple": {"cosine": 8.0, "sine": 5.0, "order": 6.0},
    "torque_delay": {"share": 1.0, "delay": 0.002},
    "torque_saturation": {"share": 0.5, "limit": 40.0},
    "gravity_spring": {"stiffness": 150.0, "preload": 90.0, "ratio": 0.5, "phase": 0.8},
    "joint_spring": {"stiffness": 40.0},
    "joint_coupling": {"inertia": 0.4, "viscous": 2.0, "coulomb": 6.0},
    "payload": {"mass": 4.0},
}
REMEMBERING = [name for name, effect in CATALOGUE.items() if effect.states]


def robot_with(effect: str, rigid: bool = False) -> Robot:
    robot = load_robot(TWO_LINK)
    joint = 2 if effect == "payload" else 1
    values = {f"joint{joint}.{effect}.{name}": value for name, value in STRONG[effect].items()}
    return robot.with_effect(joint, effect).with_parameters(values, f"two_link_{effect}")


def experiment(duration: float = 1.2) -> Experiment:
    """Both joints swing with reversals, shaken by tones that bend the hinges."""
    time = np.arange(round(duration / STEP) + 1) * STEP
    swings = np.outer(1 - np.cos(2 * np.pi * time / 0.8), [0.4, 0.5])
    tones = np.sin(np.outer(time, 2 * np.pi * np.array([9.0, 13.0])) + [0.0, 1.0])
    return Experiment(time, swings + [0.2, -0.3], tones * [30.0, 8.0])


def simulated(robot: Robot, folder: Path, plan: Experiment, fmi=2):
    speeds = [name.replace(".e", ".de", 1) for name in robot.coordinates]
    laws = [f"laws.{name}" for name in robot.coordinates]
    memories = [memory.name for memory in equations(robot).memories]
    outputs = (*speeds, *(f"der({name})" for name in speeds), *laws, *memories)
    path = export_fmu(equations(robot), folder / "robot.fmu", fmi=fmi, derivatives=False)
    with LoadedFmu(path) as fmu:
        log = fmu.simulate(plan, outputs=outputs)
    q, dq = log[list(robot.coordinates)].to_numpy(), log[speeds].to_numpy()
    ddq, tau = (
        log[[f"der({name})" for name in speeds]].to_numpy(),
        log[["joint1.tau", "joint2.tau"]].to_numpy(),
    )
    return log, Motion(q, dq, ddq, tau, plan.time), log[laws].to_numpy()


def law_forces(robot: Robot, motion: Motion, joint: int, effect: str) -> np.ndarray:
    """Columns times parameters of one law, (N, n)."""
    total = np.zeros_like(motion.q)
    for name, rows in effect_columns(robot, joint, effect, motion).items():
        for row, column in rows.items():
            total[:, row] += robot.joints[joint - 1].values[effect][name] * column
    return total


@pytest.mark.parametrize("effect", STRONG)
def test_columns_times_parameters_are_the_forces_in_the_fmu(effect, tmp_path):
    robot = robot_with(effect)
    _, motion, laws = simulated(robot, tmp_path, experiment())
    forces = {
        (k, law.name): law_forces(robot, motion, k, law.name)
        for k, joint in robot.numbered
        for law in joint.effects
    }
    ours = np.abs(sum(f for (_, name), f in forces.items() if name == effect))
    assert ours.max() > 3.0
    inside = sum(force for (_, name), force in forces.items() if name != "payload")
    moving = (motion.dq[:, :2] != 0).all(axis=1)
    assert moving.mean() > 0.9
    remembered = {"torque_delay": 0.3}.get(effect, 5e-3) * ours.max() if effect in REMEMBERING else 0.0
    tolerance = max(remembered, 1e-9 * np.abs(laws).max())
    np.testing.assert_allclose(inside[moving], laws[moving], rtol=0, atol=tolerance)

    Phi = regressor(robot, motion)
    left = Phi.matrix @ np.array([robot.linear_parameters[name] for name in Phi.columns])
    left[:, :2] -= motion.tau
    np.testing.assert_allclose(left[moving], 0, atol=max(remembered, 1e-8 * np.abs(laws).max()))
