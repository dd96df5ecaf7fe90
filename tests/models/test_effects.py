"""Every law of the catalogue: inside the FMU and as columns of Φ, and what it does to the motion."""

from pathlib import Path

import numpy as np
import pytest

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.effects import CATALOGUE
from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.estimation.identify import identify
from pyident.logs.log import Log
from pyident.regression.candidate_columns import effect_columns
from pyident.regression.regressor import regressor

TWO_LINK = Path(__file__).parents[1] / "robots" / "two_link.toml"
STEP = 0.0005  # of the logs [s]; the controller's is 0.004
STRONG: dict[str, dict[str, float]] = {
    "stribeck": {"level": 10.0, "velocity": 0.2},
    "asymmetric_coulomb": {"coulomb": 5.0, "viscous": 3.0},
    "load_dependent_friction": {"coefficient": 0.3},
    "presliding": {"level": 15.0, "travel": 0.01},
    "nonlinear_viscous": {"coefficient": 8.0, "power": 0.6},
    "position_dependent_friction": {"cosine": 6.0, "sine": 4.0, "order": 3.0},
    "viscous_drift": {"drift": 6.0},
    "coulomb_drift": {"rate": 8.0},
    "offset_drift": {"rate": 4.0},
    "directional_drift": {"drift": 6.0},
    "hardening_stiffness": {"cubic": 3e10},
    "backlash": {"stiffness": 6e4, "gap": 3e-4},
    "transmission_hysteresis": {"level": 10.0, "travel": 3e-4},
    "stiffness_coupling": {"k12": 4e4, "k13": -3e4, "k23": 5e4},
    "kinematic_error": {"cosine": 12.0, "sine": -9.0, "order": 4.0},
    "twist_offset": {"torque": 25.0},
    "torque_ripple": {"cosine": 8.0, "sine": 5.0, "order": 6.0},
    "torque_delay": {"share": 1.0, "delay": 0.002},
    "torque_saturation": {"share": 0.5, "limit": 40.0},
    "torque_droop": {"fall": 0.0005},
    "gravity_spring": {"stiffness": 150.0, "preload": 90.0, "ratio": 0.5, "phase": 0.8},
    "joint_spring": {"stiffness": 40.0, "preload": 3.0},
    "slack_spring": {
        "stiffness_below": 30.0,
        "stiffness_above": 60.0,
        "start_below": -0.05,
        "start_above": 0.05,
    },
    "joint_coupling": {"inertia": 0.4, "viscous": 2.0, "coulomb": 6.0, "ratio": 1.0},
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
    tones = np.sin(np.outer(time, 2 * np.pi * np.array([9.0, 13.0])) + np.array([0.0, 1.0]))
    return Experiment(time, swings + np.array([0.2, -0.3]), tones * np.array([30.0, 8.0]))


def simulated(robot: Robot, folder: Path, plan: Experiment):
    speeds = [name.replace(".e", ".de", 1) for name in robot.coordinates]
    laws = [f"laws.{name}" for name in robot.coordinates]
    memories = [memory.name for memory in equations(robot).memories]
    outputs = (*speeds, *(f"der({name})" for name in speeds), *laws, *memories)
    path = export_fmu(equations(robot), folder / "robot.fmu", light=True)
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
    ours = np.abs(np.sum([f for (_, name), f in forces.items() if name == effect], axis=0))
    assert ours.max() > 3.0
    inside = np.sum([force for (_, name), force in forces.items() if name != "payload"], axis=0)
    moving = (motion.dq[:, :2] != 0).all(axis=1)
    assert moving.mean() > 0.9
    remembered = {"torque_delay": 0.3}.get(effect, 5e-3) * ours.max() if effect in REMEMBERING else 0.0
    tolerance = max(remembered, 1e-9 * np.abs(laws).max())
    np.testing.assert_allclose(inside[moving], laws[moving], rtol=0, atol=tolerance)

    Phi = regressor(robot, motion)
    left = Phi.matrix @ np.array([robot.linear_parameters[name] for name in Phi.columns])
    left[:, :2] -= motion.tau
    np.testing.assert_allclose(left[moving], 0, atol=max(remembered, 1e-8 * np.abs(laws).max()))


@pytest.mark.parametrize("effect", REMEMBERING)
def test_both_kinds_of_simulation_agree_about_states(effect, tmp_path):
    from fmpy import simulate_fmu

    robot, plan = robot_with(effect), experiment(0.2)
    (memory,) = equations(robot).memories
    path = export_fmu(equations(robot), tmp_path / "robot.fmu")
    names = [f"joint{k}.{s}" for s in ("r", "tau_ff") for k in (1, 2)]
    signals = np.zeros(len(plan.time), dtype=[(n, float) for n in ("time", *names)])
    signals["time"] = plan.time
    for name, values in zip(names, np.hstack([plan.reference, plan.feedforward]).T, strict=True):
        signals[name] = values
    result = simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        stop_time=plan.time[-1],
        output_interval=0.004,
        relative_tolerance=1e-9,
        input=signals,
        output=["tip.x", memory.name],
    )
    with LoadedFmu(path) as fmu:
        log = fmu.simulate(plan, {"solver.step": 1e-4}, outputs=(memory.name,))
    last = np.searchsorted(result["time"], plan.time[::8] + 1e-9) - 1
    assert np.abs(result["tip.x"][last] - log["tip.x"].to_numpy()[::8]).max() < 1e-7
    z = log[memory.name].to_numpy()[::8]
    assert np.abs(result[memory.name][last] - z).max() < 1e-4 * np.abs(z).max()
    assert np.ptp(z) > 0.1


def test_a_saved_state_holds_the_laws_memory(tmp_path):
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    path = export_fmu(equations(robot_with("presliding")), tmp_path / "robot.fmu", light=True)
    description = read_model_description(str(path))
    vr = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=str(extract(str(path))),
        modelIdentifier=description.coSimulation.modelIdentifier,  # pyright: ignore
        instanceName="robot",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.setReal([vr["joint1.r"]], [0.3])
    seen = [vr["joint1.presliding.bristle"], vr["joint1.e"], vr["laws.joint1.e"]]
    for i in range(5):
        fmu.doStep(i * 0.003, 0.003)
    state, before = fmu.getFMUState(), fmu.getReal(seen)

    def onwards():
        for i in range(20):
            fmu.doStep(0.015 + i * 0.003, 0.003)
        return fmu.getReal(seen)

    first = onwards()
    assert first != before
    assert abs(before[0]) > 0.1
    fmu.setFMUState(state)
    assert fmu.getReal(seen) == before
    assert onwards() == first
    fmu.freeFMUState(state)
    fmu.terminate()
    fmu.freeInstance()


def test_dahl_friction_is_its_closed_form():
    """Between reversals, at any speed: z = s - (s - z0) exp(-s (x - x0)/travel), s the direction."""
    robot = robot_with("presliding")
    time = np.arange(4001) * 0.001
    x = 0.03 * np.sin(2 * np.pi * time / 4)  # turns at 1 s and 3 s
    v = 0.03 * 2 * np.pi / 4 * np.cos(2 * np.pi * time / 4)
    q, dq = np.zeros((4001, 8)), np.zeros((4001, 8))
    q[:, 0], dq[:, 0] = x, v
    column = effect_columns(robot, 1, "presliding", Motion(q, dq, 0 * q, None, time))["level"][0]
    z, here, place = np.zeros(4001), 0.0, 0.0
    for part, s in ((slice(0, 1001), 1), (slice(1001, 3001), -1), (slice(3001, 4001), 1)):
        z[part] = s - (s - here) * np.exp(-s * (x[part] - place) / 0.01)
        here, place = z[part][-1], x[part][-1]
    moving = np.abs(v) > 1e-4
    np.testing.assert_allclose((column + np.sign(v))[moving], z[moving], atol=1e-4)


def test_friction_that_is_cancelled_neither_sticks_nor_chatters(tmp_path):
    """Dahl friction in place of Coulomb's: under a small torque the hinge yields like a spring."""
    robot = robot_with("presliding").with_parameters({"joint1.viscous": 20.0})
    still = Experiment(np.arange(1001) * 0.004, np.zeros((1001, 2)), np.zeros((1001, 2)))
    still.feedforward[10:, 0] = 6.0
    off = {f"joint1.{gain}": 0.0 for gain in ("Kp", "Kd", "Ki")}
    path = export_fmu(equations(robot), tmp_path / "robot.fmu", light=True)
    with LoadedFmu(path) as fmu:
        log = fmu.simulate(still, off, outputs=("joint1.de", "joint1.presliding.bristle", "laws.joint1.e"))
    yielded = log["joint1.e"].iloc[-1] - log["joint1.e"].iloc[0]
    assert 1e-3 < yielded < 0.1  # without it the 15 N m of Coulomb would hold the joint still
    assert abs(log["joint1.de"].iloc[-1]) < 1e-3
    assert 0 < log["joint1.presliding.bristle"].iloc[-1] < 1


def test_a_late_torque_under_the_hat(tmp_path):
    """At the controller's rate the column is the hat's mean of tau - z, as a far finer log has it."""
    robot, fine = robot_with("torque_delay"), 20
    plan = experiment(0.6)
    time = np.arange(0, plan.time[-1], 0.004 / fine)
    inputs = [
        np.column_stack([np.interp(time, plan.time, c) for c in s.T])
        for s in (plan.reference, plan.feedforward)
    ]
    log, motion, _ = simulated(robot, tmp_path, Experiment(time, *inputs))  # pyright: ignore[reportArgumentType]
    late = log["joint1.tau"].to_numpy() - log["joint1.torque_delay.delivered"].to_numpy()
    z, tau = log["joint1.torque_delay.delivered"].to_numpy(), motion.tau
    assert tau is not None
    coarse = Motion(
        motion.q[::fine], motion.dq[::fine], motion.ddq[::fine], tau[::fine], time[::fine],
        np.concatenate([tau[:1], tau[::fine][:-1]]),
    )  # fmt: skip
    column = effect_columns(robot, 1, "torque_delay", coarse)["share"][0]
    hat = np.concatenate([np.arange(fine), fine - np.arange(fine)]) / fine**2
    middle = range(1, len(column) - 1)
    z_mean = np.array([np.sum(z[(i - 1) * fine : (i + 1) * fine] * hat) for i in middle])
    want = (tau[::fine, 0][1:-1] + tau[::fine, 0][:-2]) / 2 - z_mean
    assert np.abs(late).max() > 10
    np.testing.assert_allclose(column[1:-1], want, atol=0.02 * np.abs(want).max())


def test_dissipation_takes_power_and_springs_give_it_back():
    rng = np.random.default_rng(3)
    robot = load_robot(TWO_LINK)
    q, dq, ddq = (rng.normal(size=(50, 8)) * 0.5 for _ in range(3))
    motion = Motion(q, dq, ddq, rng.normal(size=(50, 2)), np.arange(50.0))
    back = Motion(motion.q, -motion.dq, motion.ddq, motion.tau, motion.time)
    for name in ("stribeck", "load_dependent_friction", "nonlinear_viscous"):
        (forth,) = effect_columns(robot, 1, name, motion).values()
        (again,) = effect_columns(robot, 1, name, back).values()
        assert (forth[0] * motion.dq[:, 0] >= 0).all()
        np.testing.assert_allclose(again[0], -forth[0])
    for name in (
        "kinematic_error",
        "gravity_spring",
        "joint_spring",
        "slack_spring",
        "hardening_stiffness",
        "stiffness_coupling",
        "twist_offset",
    ):
        assert_conservative(robot, name, motion.q)


def test_a_gap_of_which_no_load_reaches_the_other_side_is_a_zero_and_both_names_are_told():
    rng = np.random.default_rng(4)
    robot = load_robot(TWO_LINK).with_effect(1, "backlash").with_parameters({"joint1.backlash.gap": 1e-4})
    q, dq, ddq = (rng.normal(size=(50, 8)) * 0.5 for _ in range(3))
    twist = robot.coordinates.index("joint1.eps[1]")
    q[:, twist] = 2e-4 + np.abs(q[:, twist])  # always loaded the same way
    motion = Motion(q, dq, ddq)
    gap = effect_columns(robot, 1, "backlash", motion)["stiffness"][twist]
    zero = effect_columns(robot, 1, "twist_offset", motion)["torque"][twist]
    np.testing.assert_allclose(gap, -1e-4 * zero)
    assert "backlash" in CATALOGUE["twist_offset"].confounders


def assert_conservative(robot: Robot, name: str, q: np.ndarray) -> None:
    """d(force_i)/d(q_j) is symmetric."""
    robot = robot_with(name)

    def force(q: np.ndarray) -> np.ndarray:
        return law_forces(robot, Motion(q, 0 * q, 0 * q), 1, name)

    h = 1e-6
    slopes = np.stack([(force(q + h * d) - force(q - h * d)) / (2 * h) for d in np.eye(8)], axis=2)
    np.testing.assert_allclose(slopes, slopes.transpose(0, 2, 1), atol=1e-6 * np.abs(slopes).max())


def test_a_robot_with_more_laws_is_identified(tmp_path):
    """Linear parameters of laws with and without states are found; nonlinear ones are kept."""
    robot = load_robot(TWO_LINK)
    for name in ("stribeck", "transmission_hysteresis", "gravity_spring"):
        values = {f"joint1.{name}.{p}": v for p, v in STRONG[name].items()}
        robot = robot.with_effect(1, name).with_parameters(values)
    plan = experiment(8.0)
    plan = Experiment(plan.time[::8], plan.reference[::8], plan.feedforward[::8])
    log, _, _ = simulated(robot, tmp_path, plan)
    found = identify(robot, [Log(log, "log")])
    assert found.robot.parameters["joint1.stribeck.velocity"] == 0.2
    assert found.relative_error["all"] < 5.0
    assert "joint1.stribeck.velocity" not in found.json()["parameters"]
    level = found.robot.parameters["joint1.transmission_hysteresis.level"]
    assert level == pytest.approx(10.0, rel=0.3)
