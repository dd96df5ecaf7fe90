"""MJCF in and out: mass matrix, forces and motion against MuJoCo, which reads the original file itself."""

import os
import re
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexmodels.files.mjcf.exporter import export_mjcf
from flexmodels.files.mjcf.importer import import_mjcf
from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.mechanics import dynamics
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot, RobotError
from flexmodels.settings.controller import Controller

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is the oracle and is not installed")
FOLDER = Path(__file__).parents[2] / "robots" / "mjcf"
OWN = ("arm", "gantry", "legs", "servo_arm", "defaults")


@pytest.fixture(params=[*OWN, "so101"])
def file(request):
    if request.param in OWN:
        return FOLDER / f"{request.param}.xml"
    data = os.environ.get("PYIDENT_DATA")
    if not data:
        pytest.skip("PYIDENT_DATA does not point at the measured data, of which so101.xml is part")
    return Path(data) / "so101" / "so101.xml"


class Reference:
    """The file in MuJoCo, spoken to in the robot's coordinates. G: speeds of MuJoCo per driven speed."""

    def __init__(self, file: Path, robot: Robot):
        spec = mujoco.MjSpec.from_file(str(file))
        for joint in list(spec.joints):
            if joint.type == mujoco.mjtJoint.mjJNT_FREE:
                spec.delete(joint)
        for geom in spec.geoms:
            geom.contype = geom.conaffinity = 0
        for joint in spec.joints:
            joint.limited = False
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        names = [joint.name for joint in robot.joints]
        self.G = np.zeros((self.model.nv, len(names)))
        for i, name in enumerate(names):
            self.G[self.model.joint(name).dofadr[0], i] = 1.0
        for i in range(self.model.neq):
            follower, leader = self.model.eq_obj1id[i], self.model.eq_obj2id[i]
            row = self.G[self.model.jnt_dofadr[leader]] * self.model.eq_data[i][1]
            self.G[self.model.jnt_dofadr[follower]] = row

    def at(self, e, de):
        self.data.qpos[:], self.data.qvel[:] = self.G @ e, self.G @ de
        mujoco.mj_forward(self.model, self.data)

    def mass_matrix(self, e):
        self.at(e, 0 * e)
        M = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, M)
        return self.G.T @ M @ self.G

    def forces(self, e, de):
        self.at(e, de)
        return self.G.T @ (self.data.qfrc_bias - self.data.qfrc_passive)


@pytest.fixture
def robot(file):
    return import_mjcf(file).robot


@pytest.fixture
def reference(file, robot):
    return Reference(file, robot)


def _poses(robot: Robot, count: int):
    rng = np.random.default_rng(4)
    n = len(robot.joints)
    return [(rng.uniform(-2, 2, n), rng.uniform(-3, 3, n)) for _ in range(count)]


def _without_dry_friction(robot: Robot) -> Robot:
    n = len(robot.joints)
    rest = {f"joint{k}.coulomb": 0.0 for k, _ in robot.numbered}
    controller = Controller(1000.0, (1.0,) * n, (0.0,) * n, (0.0,) * n)
    return replace(robot.with_parameters(rest), controller=controller)


def _rates(robot: Robot):
    """de, dde of (e, de) under motor torques, from the equations of which FMUs are made."""
    eq = equations(_without_dry_friction(robot))
    p, n = list(eq.parameters.values()), eq.joints
    return lambda x, u: np.array(eq.rates(x, u, p, np.ones(n))[0]).ravel()


def test_mass_matrix(robot, reference):
    m = dynamics.mechanism(robot)
    a = ca.SX.sym("a", m.q.numel())
    M = ca.jacobian(dynamics.inverse_dynamics(m, a), a)
    of_links = ca.Function("M", [m.q, m.bodies], [M])
    armature = np.diag([joint.values["motor_inertia"]["J_m"] for joint in robot.joints])
    bodies = np.array([list(link.values.values()) for link in robot.links]).T
    for e, _ in _poses(robot, 20):
        expected = reference.mass_matrix(e)
        np.testing.assert_allclose(np.array(of_links(e, bodies)) + armature, expected, rtol=0, atol=1e-9)


def test_forces(robot, reference):
    """M dde + h = 0 at what MuJoCo itself says M and h are."""
    rates, n = _rates(robot), len(robot.joints)
    for e, de in _poses(robot, 20):
        dde = rates(np.r_[e, de], np.zeros(n))[n:]
        M, h = reference.mass_matrix(e), reference.forces(e, de)
        np.testing.assert_allclose(M @ dde, -h, rtol=0, atol=1e-9 * max(1.0, float(np.abs(h).max())))


def test_simulated_motion(robot, reference):
    """Half a second of free motion under constant torques, by MuJoCo's own steps where nothing follows."""
    n, m, d = len(robot.joints), reference.model, reference.data
    u = 0.2 * np.arange(1, n + 1)
    rates = _rates(robot)
    solved = solve_ivp(lambda _, x: rates(x, u), (0, 0.5), np.zeros(2 * n), "DOP853", rtol=1e-11, atol=1e-12)
    ours = solved.y[:n, -1]
    if m.neq:  # MuJoCo ties joints by soft springs: its M and h, tied exactly, stand for it

        def rate(_, x):
            M, h = reference.mass_matrix(x[:n]), reference.forces(x[:n], x[n:])
            return np.r_[x[n:], np.linalg.solve(M, u - h)]

        theirs = solve_ivp(rate, (0, 0.5), np.zeros(2 * n), "DOP853", rtol=1e-11, atol=1e-12).y[:n, -1]
    else:
        m.dof_frictionloss[:] = 0.0
        m.actuator_gainprm[:], m.actuator_biasprm[:] = 0.0, 0.0
        m.opt.timestep, m.opt.integrator = 1e-4, mujoco.mjtIntegrator.mjINT_RK4
        reference.at(np.zeros(n), np.zeros(n))
        d.qfrc_applied[:] = reference.G @ u
        for _ in range(5000):
            mujoco.mj_step(m, d)
        theirs = reference.G.T @ d.qpos
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6)


def test_round_trip_in_mujoco(file, robot, reference, tmp_path):
    """What is written moves in MuJoCo like the original, dry friction and servos included."""
    export_mjcf(robot, tmp_path / "again.xml")
    again = import_mjcf(tmp_path / "again.xml").robot
    second = Reference(tmp_path / "again.xml", again)
    n = len(robot.joints)
    for e, de in _poses(robot, 10):
        np.testing.assert_allclose(second.mass_matrix(e), reference.mass_matrix(e), rtol=0, atol=1e-9)
        np.testing.assert_allclose(second.forces(e, de), reference.forces(e, de), rtol=0, atol=1e-9)
    if reference.model.neq:
        return  # its soft springs answer to each joint's armature, which the leader carries here
    ends = []
    moved = reference.model.qpos0.any()  # MuJoCo weighs its soft dry friction by the inertia at `ref`
    for one in (reference, second):
        one.model.opt.timestep, one.model.opt.integrator = 1e-3, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        one.model.dof_frictionloss[:] *= 0.0 if moved else 1.0
        one.at(np.zeros(n), np.full(n, 0.5))
        if robot.controller:
            one.data.ctrl[:] = 0.1
        else:  # no servos, or at some joints only, which is said and left out
            one.model.actuator_gainprm[:], one.model.actuator_biasprm[:] = 0.0, 0.0
            one.data.qfrc_applied[:] = one.G @ np.full(n, 0.1)
        for _ in range(500):
            mujoco.mj_step(one.model, one.data)
        ends.append(np.linalg.pinv(one.G) @ one.data.qpos)
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-6)


def test_robot_file_keeps_everything(robot, tmp_path):
    save_robot(robot, tmp_path / "robot.toml")
    read = load_robot(tmp_path / "robot.toml")
    assert read.parameters == robot.parameters
    assert read.passive == robot.passive
    assert read.controller == robot.controller


def test_tip_and_names():
    robot = import_mjcf(FOLDER / "arm.xml").robot
    spec = mujoco.MjSpec.from_file(str(FOLDER / "arm.xml"))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    m = dynamics.mechanism(robot)
    tip = ca.Function("tip", [m.q], [dynamics.tip_position(m)])
    e = np.array([data.qpos[model.joint(joint.name).qposadr[0]] for joint in robot.joints])
    np.testing.assert_allclose(np.array(tip(e)).ravel(), data.site("tool").xpos, atol=1e-12)
    assert [joint.name for joint in robot.joints] == ["pan", "lift", "elbow", "wrist1", "wrist2", "wrist3"]


def test_flexible_hinges_are_written_as_joints_with_springs(tmp_path):
    """Small deformations: M and the springs' forces of the file against the robot's own equations."""
    robot = import_mjcf(FOLDER / "servo_arm.xml", flexible=[2], twist=[3]).robot
    export_mjcf(robot, tmp_path / "flexible.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "flexible.xml"))
    data = mujoco.MjData(model)
    eq = equations(_without_dry_friction(robot))
    names = {"joint1.e": "pan", "joint2.e": "lift", "joint3.e": "elbow", "joint4.e": "jaw"}
    names |= {f"joint2.eps[{i}]": f"lift_eps{i}" for i in (1, 2, 3)} | {"joint3.eps[1]": "elbow_eps1"}
    order = [model.joint(names[q]).dofadr[0] for q in eq.coordinates]
    rng = np.random.default_rng(0)
    q = np.r_[rng.uniform(-1, 1, 4), rng.uniform(-1e-4, 1e-4, 4)]
    data.qpos[order], data.qvel[:] = q, 0.0
    model.dof_frictionloss[:] = 0.0
    model.actuator_gainprm[:], model.actuator_biasprm[:] = 0.0, 0.0
    mujoco.mj_forward(model, data)
    x, p = np.r_[q, np.zeros(8)], list(eq.parameters.values())
    ours = np.array(eq.rates(x, np.zeros(4), p, np.ones(4))[0]).ravel()[8:]
    np.testing.assert_allclose(data.qacc[order], ours, rtol=0, atol=1e-3 * np.abs(ours).max())


@pytest.mark.parametrize("rod", [0.0, 0.004], ids=["point", "rod"])
def test_a_load_without_extent_is_written(rod, tmp_path):
    """0.49 kg at 0.1 m, by rounding a little less than a rigid body; M against m l² and the rod's."""
    load = Link.of_centre(0.49, np.array([0.0, 0.0, -0.1]), np.diag([rod, rod, 0.0]))
    joint = Joint("revolute", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), False, {})
    robot = Robot("stand", (joint,), (load,), (0.0, 0.0, -0.1))
    export_mjcf(robot, tmp_path / "stand.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "stand.xml"))
    data, inertia = mujoco.MjData(model), np.zeros((1, 1))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, inertia)
    assert inertia[0, 0] == pytest.approx(0.49 * 0.1**2 + rod, abs=1e-11)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('type="slide" axis="1 0 0"', 'type="ball"', "is a ball; replace it by three hinges"),
        ('polycoef="0 -1 0 0 0"', 'polycoef="0.1 -1 0 0 0"', "only a factor is read"),
        ('polycoef="0 -1 0 0 0"', 'polycoef="0 -1 2 0 0"', "only a factor is read"),
        ("<worldbody>", "<worldbodi>", "cannot be read as MJCF"),
    ],
)
def test_refusals(tmp_path, old, new, sentence):
    text = (FOLDER / "gantry.xml").read_text()
    if "ball" in new:
        old = ' range="-1 1"'
        text = text.replace(old, "").replace('type="slide" axis="1 0 0" damping="5" armature="2"', new)
    (tmp_path / "bad.xml").write_text(text.replace(old, new))
    with pytest.raises(RobotError, match=sentence):
        import_mjcf(tmp_path / "bad.xml")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("", "", "the gains of the position servos are left out, as j4, f1, f2 has none"),
        ("", "", "actuators grip are neither motors nor position servos"),
        ("", "", "1 tendons are left out"),
        ('name="hand"', 'name="hand" gravcomp="1"', "gravcomp of hand is left out"),
        ('integrator="implicitfast"', 'integrator="implicitfast" density="1.2"', "the forces of the fluid"),
        (
            '<motor name="a4"',
            '<general name="a4" dyntype="filter" dynprm="0.1"',
            r"the dynamics \(dyntype\) of actuators a4",
        ),
    ],
)
def test_what_is_left_out_is_said(tmp_path, old, new, sentence):
    text = (FOLDER / "defaults.xml").read_text()
    text = text.replace(old, new) if new else text
    (tmp_path / "changed.xml").write_text(text)
    (tmp_path / "defaults_common.xml").write_text((FOLDER / "defaults_common.xml").read_text())
    assert any(re.match(sentence, note) for note in import_mjcf(tmp_path / "changed.xml").notes)


def test_a_slider_that_follows_is_refused_with_the_cure(tmp_path):
    text = (FOLDER / "defaults.xml").read_text()
    tied = '<equality><joint joint1="f2" joint2="f1"/></equality><actuator>'
    (tmp_path / "tied.xml").write_text(text.replace("<actuator>", tied))
    (tmp_path / "defaults_common.xml").write_text((FOLDER / "defaults_common.xml").read_text())
    with pytest.raises(
        RobotError, match=r"joint f2 is a slider that follows another; .* delete the equality"
    ):
        import_mjcf(tmp_path / "tied.xml")


def test_mesh_files_may_be_missing_where_inertias_are_given(tmp_path):
    text = (FOLDER / "servo_arm.xml").read_text()
    asset = '<asset><mesh name="part" file="nowhere.stl"/></asset><worldbody>'
    text = text.replace("<worldbody>", asset)
    text = text.replace('<joint name="pan"', '<geom type="mesh" mesh="part"/><joint name="pan"')
    (tmp_path / "meshes.xml").write_text(text)
    robot = import_mjcf(tmp_path / "meshes.xml").robot
    assert robot.parameters == import_mjcf(FOLDER / "servo_arm.xml").robot.parameters
