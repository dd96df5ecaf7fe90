"""The palletiser, a robot with a closed loop, from its file to its identification."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, random_motion
from scipy.integrate import solve_ivp

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment, identification, line
from flexmodels.files.robot_file import load_robot
from flexmodels.loops.linkage import Closure
from flexmodels.mechanics import dynamics
from flexmodels.mechanics.plant import equations
from pyident.conditioning.motion import Motion
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import weighted
from pyident.estimation.identify import identified
from pyident.kinematics import loop, transfer
from pyident.kinematics.elements.triads import cross, rotate
from pyident.kinematics.robot_structure import of_robot
from pyident.kinematics.structure import StructureError
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.regression.regressor import regressor

ROBOT = load_robot("parallelogram")
SHOULDER, LOWER, REACH, DROP = (0.25, 0.8), 1.0, 1.3, 0.2  # of parallelogram.toml [m]


@pytest.fixture(scope="module")
def fmu_file(tmp_path_factory):
    return export_fmu(equations(ROBOT), tmp_path_factory.mktemp("fmu") / "parallelogram.fmu")


@pytest.fixture(scope="module")
def log(fmu_file):
    """Noise-free log of the identification experiment."""
    with LoadedFmu(fmu_file) as fmu:
        return Log(fmu.simulate(identification(ROBOT)), "identification")


def closed_form(q, dq):
    """Tip position and velocity (3, N), the column not tilting: the upper arm stays parallel to the crank."""
    s, ds = ca.SX.sym("s", 8), ca.SX.sym("ds", 8)
    column, lower, crank = s[0] + s[3], s[1] + s[6], s[2] + s[7]
    reach = SHOULDER[0] + LOWER * ca.sin(lower) + REACH * ca.cos(crank) - DROP * ca.sin(crank)
    height = SHOULDER[1] + LOWER * ca.cos(lower) - REACH * ca.sin(crank) - DROP * ca.cos(crank)
    tip = ca.vertcat(reach * ca.cos(column), reach * ca.sin(column), height)
    found = ca.Function("tip", [s, ds], [tip, ca.jtimes(tip, s, ds)])(q, dq)
    return [np.array(value) for value in found]


def untilted_motion():
    q, dq, ddq = (rate.T.copy() for rate in random_motion(ROBOT, 40))
    for rate in (q, dq, ddq):
        rate[4:6] = 0
    return q, dq, ddq


def test_tip_of_finite_elements_and_plant_against_the_closed_form():
    q, dq, ddq = untilted_motion()
    x, v = closed_form(q, dq)
    nodes = transfer.nodes(of_robot(ROBOT), q, dq, ddq)
    place, R = of_robot(ROBOT).bodies[4]
    position, orientation = nodes.positions[place], nodes.orientations[R]
    arm = rotate(orientation.R, np.array(ROBOT.tip))
    np.testing.assert_allclose(position.x + arm, x, atol=1e-12)
    np.testing.assert_allclose(position.v + cross(orientation.w, arm), v, atol=1e-11)
    m = dynamics.mechanism(ROBOT)
    tip = dynamics.tip_position(m)
    plant = ca.Function("tip", [m.q, m.v], [tip, ca.jtimes(tip, m.q, m.v)])(q, dq)
    for ours, want in zip(plant, (x, v), strict=True):
        np.testing.assert_allclose(np.array(ours), want, atol=1e-12)


def test_the_pin_turns_the_passive_joints_as_follows_says():
    structure, q = of_robot(ROBOT), random_motion(ROBOT, 40)[0].T
    shape = loop.configuration(structure, q)
    twists = [mode for mode in structure.released if mode[1] == 0]
    rod, upper_arm, pin = (structure.elements[i].D(shape)[0] for i, _ in twists)
    np.testing.assert_allclose(np.stack([rod, upper_arm]), ROBOT.following @ q, atol=1e-12)
    np.testing.assert_allclose(pin, upper_arm, atol=1e-12)
    for i, mode in structure.released:
        if mode:
            assert np.abs(structure.elements[i].D(shape)[mode]).max() < 1e-12


@pytest.mark.parametrize("robot", [ROBOT, load_robot("four_link")], ids=lambda robot: robot.name)
def test_Phi_p_is_the_torque_in_the_plant(robot):
    """Forward dynamics of the plant, all laws included; back through finite elements and Phi."""
    q, dq, _ = random_motion(robot, 30)
    eq, n = equations(robot), len(robot.coordinates)
    p, known = list(robot.parameters.values()), list(eq.parameters.values())
    u = np.random.default_rng(2).normal(size=(30, eq.joints)) * 100
    mode = np.sign(dq[:, : eq.joints])
    ddq = np.stack(
        [np.array(eq.rates(np.r_[q[i], dq[i]], u[i], known, mode[i])[0])[n:, 0] for i in range(len(q))]
    )
    force = regressor(robot, Motion(q, dq, ddq)).matrix @ p
    want = np.hstack([u, np.zeros((30, n - eq.joints))])
    size = np.abs(q @ np.diag([robot.parameters.get(c.replace("eps", "k"), 0) for c in robot.coordinates]))
    np.testing.assert_allclose(force, want, atol=1e-11 * size.max())


def test_the_fmu_agrees_with_an_integration_through_pinocchio(fmu_file):
    """0.5 s under constant torques, gains and Coulomb friction off."""
    time, pose = np.arange(126) * 0.004, np.tile([0.2, 0.3, -0.1], (126, 1))
    push = np.tile([300.0, -250.0, 150.0], (126, 1))
    off = {f"joint{k}.{name}": 0.0 for k in (1, 2, 3) for name in ("Kp", "Kd", "Ki", "coulomb")}
    with LoadedFmu(fmu_file) as fmu:
        run = fmu.simulate(Experiment(time, pose, push), off | {"solver.step": 1e-4})
    q = run[list(ROBOT.coordinates)].to_numpy()
    p, oracle, n = ROBOT.parameters, PinocchioRobot(ROBOT), len(ROBOT.coordinates)
    u = np.r_[run.loc[0, [f"joint{k}.tau" for k in (1, 2, 3)]].to_numpy(float), np.zeros(5)]
    armature = np.diag([p.get(c[:6] + ".J_m", 0.0) if c.endswith(".e") else 0.0 for c in ROBOT.coordinates])
    k = np.array([p.get(c.replace("eps", "k"), 0.0) for c in ROBOT.coordinates])
    d = np.array(
        [p[c[:6] + ".viscous"] if c.endswith(".e") else p[c.replace("eps", "d")] for c in ROBOT.coordinates]
    )

    def rates(_, x):
        at, v = x[:n], x[n:]
        net = u - k * at - d * v - oracle.inverse_dynamics(at, v, 0 * v)
        return np.r_[v, np.linalg.solve(oracle.mass_matrix(at) + armature, net)]

    start = np.r_[q[0], np.zeros(n)]
    want = solve_ivp(rates, (0, time[-1]), start, "DOP853", time, rtol=1e-10, atol=1e-12)
    assert np.abs(q[-1, :3] - q[0, :3]).min() > 0.05
    np.testing.assert_allclose(q, want.y[:n].T, atol=1e-8)


def test_the_controller_follows_both_experiments(fmu_file, log):
    assert np.abs(log.signals(["joint1.e", "joint2.e", "joint3.e"])).max() < 1.6
    with LoadedFmu(fmu_file) as fmu:
        run = fmu.simulate(line(ROBOT))
    for plan, frame in ((line(ROBOT), run), (identification(ROBOT), log.frame)):
        e = frame[["joint1.e", "joint2.e", "joint3.e"]].to_numpy()
        assert np.abs(e - plan.reference).max() < 5e-3
    assert np.abs(run[["tip.x", "tip.z"]].to_numpy() - [1.45, 0.9]).max() < 3e-3


@pytest.fixture(scope="module")
def fitted(log):
    found = weighted(Problem(ROBOT, (condition(log, ROBOT),))).with_long_memory()
    return found.reduced, found.solution


def assert_close_to_the_truth(values):
    for k in (1, 2, 3):
        for name in (f"joint{k}.k[1]", f"joint{k}.J_m", f"joint{k}.coulomb"):
            assert values[name] == pytest.approx(ROBOT.parameters[name], rel=0.02)


def test_stiffness_and_rank_are_found(fitted):
    reduced, solution = fitted
    assert_close_to_the_truth(dict(zip(reduced.columns, solution.p, strict=True)))
    assert len(reduced.columns) == 69
    assert solution.rank == 44


def test_it_is_identified(fitted):
    found = identified(ROBOT, *fitted)
    assert_close_to_the_truth(found.robot.parameters)
    assert found.support["joint2.k[1]"] == "alone"
    assert found.relative_error["all"] < 1


def test_a_closure_without_its_rod_is_refused():
    turned = replace(ROBOT, closures=(replace(ROBOT.closures[0], links=(2, 4)),))
    with pytest.raises(StructureError, match="closure of links 2 and 4 needs a passive first link"):
        of_robot(turned)
    with pytest.raises(StructureError, match="hold 2 more"):
        of_robot(replace(ROBOT, closures=()))
    point = (-0.1, 0.3, 0.8)
    with pytest.raises(StructureError, match="lies on the axis of its rod's own joint"):
        of_robot(replace(ROBOT, closures=(Closure((4, 5), point, (0.0, 1.0, 0.0)),)))
    elbow = Closure((4, 5), (0.25, 0.0, 1.8), (0.0, 1.0, 0.0))
    with pytest.raises(StructureError, match="lies in the joint of its second link"):
        of_robot(replace(ROBOT, closures=(elbow,)))
