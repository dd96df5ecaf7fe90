"""Public URDF files: the same mass matrix, forces and regressor as Pinocchio reads out of the same file."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from click.testing import CliRunner
from pinocchio_model import pin  # pyright: ignore[reportMissingImports]

from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.files.urdf.exporter import export_urdf
from flexmodels.files.urdf.importer import import_urdf
from flexmodels.link import Link
from flexmodels.mechanics import dynamics
from flexmodels.robot import Robot, RobotError
from pyident.cli.main import main
from pyident.conditioning.motion import Motion
from pyident.regression.regressor import regressor

PUBLIC = {  # a chain of revolute joints; one with a slider and wheels; legs on a trunk
    "ur5": "ur_description/urdf/ur5_robot.urdf",
    "tiago": "tiago_description/robots/tiago_no_hand.urdf",
    "solo12": "solo_description/robots/solo12.urdf",
    "pendulum": "double_pendulum_description/urdf/double_pendulum_continuous.urdf",
}


def public(file: str) -> Path:
    import cmeel  # pyright: ignore[reportMissingImports]

    folder = Path(cmeel.__file__).parents[1] / "cmeel.prefix/share/example-robot-data/robots"
    if not folder.is_dir():
        pytest.skip("the URDF files of the package example-robot-data are not installed")
    return folder / file


@pytest.fixture(params=PUBLIC)
def urdf(request):
    return public(PUBLIC[request.param])


class Reference:
    """The file in Pinocchio, spoken to in our order of joints."""

    def __init__(self, file: Path, robot: Robot, fixed: tuple[str, ...] = ()):
        whole = pin.buildModelFromUrdf(str(file))
        still = [whole.getJointId(name) for name in fixed]
        self.model = pin.buildReducedModel(whole, still, pin.neutral(whole)) if fixed else whole
        self.data = self.model.createData()
        self.ids = [self.model.getJointId(joint.name) for joint in robot.joints]
        self.order = [self.model.joints[i].idx_v for i in self.ids]
        self.base = self.model.createData()
        pin.forwardKinematics(self.model, self.base, pin.neutral(self.model))

    def state(self, q):
        z = np.zeros(self.model.nv)
        z[self.order] = q
        return pin.integrate(self.model, pin.neutral(self.model), z)

    def speed(self, dq):
        v = np.zeros(self.model.nv)
        v[self.order] = dq
        return v

    def mass_matrix(self, q):
        M = pin.crba(self.model, self.data, self.state(q))
        M = np.triu(M) + np.triu(M, 1).T
        return M[np.ix_(self.order, self.order)]

    def forces(self, q, dq, ddq):
        return pin.rnea(self.model, self.data, self.state(q), self.speed(dq), self.speed(ddq))[self.order]

    def regressor(self, q, dq, ddq):
        """(n, 10 n) per unit of our lumped parameters."""
        Y = pin.computeJointTorqueRegressor(
            self.model, self.data, self.state(q), self.speed(dq), self.speed(ddq)
        )[self.order]
        return np.hstack(
            [Y[:, 10 * (i - 1) : 10 * i] @ _into_frame(self.base.oMi[i].rotation) for i in self.ids]
        )


def _into_frame(R):
    """10 x 10: our (m, ms, Jxx, Jxy, Jxz, Jyy, Jyz, Jzz) in base axes -> Pinocchio's in the axes R."""
    T = np.zeros((10, 10))
    for i in range(10):
        xx, xy, xz, yy, yz, zz = np.eye(10)[i, 4:]
        J = R.T @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R
        T[0, i] = np.eye(10)[i, 0]
        T[1:4, i] = R.T @ np.eye(10)[i, 1:4]
        T[4:, i] = J[0, 0], J[0, 1], J[1, 1], J[0, 2], J[1, 2], J[2, 2]
    return T


def _apart(ours, theirs):
    """Largest difference over the largest entry."""
    return np.abs(ours - theirs).max() / np.abs(theirs).max()


def motion(robot, samples=5, seed=1):
    rng = np.random.default_rng(seed)
    shape = samples, len(robot.joints)
    return rng.uniform(-2, 2, shape), rng.uniform(-2, 2, shape), rng.uniform(-5, 5, shape)


def test_mass_matrix_and_forces_are_pinocchios(urdf):
    robot = import_urdf(urdf)
    reference, m = Reference(urdf, robot), dynamics.mechanism(robot)
    n = len(robot.joints)
    a = ca.SX.sym("a", n)
    values = ca.DM(np.array([list(link.values.values()) for link in robot.links]).T)
    f = ca.Function("f", [m.q, m.v, a, m.bodies], [dynamics.inverse_dynamics(m, a)])
    for q, dq, ddq in zip(*motion(robot), strict=True):
        assert _apart(np.array(f(q, dq, ddq, values)).ravel(), reference.forces(q, dq, ddq)) < 1e-9
        h = np.array(f(q, dq, 0, values)).ravel()
        assert _apart(h, reference.forces(q, dq, 0 * q)) < 1e-9
        rest = np.array(f(q, 0, 0, values)).ravel()
        M = np.column_stack([np.array(f(q, 0, e, values)).ravel() - rest for e in np.eye(n)])
        assert _apart(M, reference.mass_matrix(q)) < 1e-9


def test_the_regressor_is_pinocchios(urdf):
    robot = import_urdf(urdf)
    reference = Reference(urdf, robot)
    Phi = regressor(robot, Motion(*motion(robot))).matrix[:, :, : 10 * len(robot.links)]
    for ours, state in zip(Phi, zip(*motion(robot), strict=True), strict=True):
        assert _apart(ours, reference.regressor(*state)) < 1e-9


def test_a_grippers_fingers_can_stand_still():
    """One is named, the other mimics it; masses of both belong to the last link, as Pinocchio has them."""
    file, fingers = (
        public("panda_description/urdf/panda.urdf"),
        ("panda_finger_joint1", "panda_finger_joint2"),
    )
    with pytest.raises(RobotError, match=r"fix both \(--fixed panda_finger_joint1\)"):
        import_urdf(file)
    with pytest.raises(RobotError, match="there is no joint finger to be fixed; the file has panda_joint1, "):
        import_urdf(file, fixed=["finger"])
    robot = import_urdf(file, fixed=fingers[:1])
    assert len(robot.joints) == 7
    reference = Reference(file, robot, fingers)
    p = np.concatenate([list(link.values.values()) for link in robot.links])
    Phi = regressor(robot, Motion(*motion(robot))).matrix[:, :, : len(p)]
    for ours, state in zip(Phi, zip(*motion(robot), strict=True), strict=True):
        assert _apart(ours @ p, reference.forces(*state)) < 1e-9


def test_import_export_import(urdf, tmp_path):
    first = import_urdf(urdf)
    export_urdf(first, tmp_path / "again.urdf")
    second = import_urdf(tmp_path / "again.urdf")
    assert [j.name for j in second.joints] == [j.name for j in first.joints]
    assert [j.limits for j in second.joints] == [j.limits for j in first.joints]
    assert second.parents == first.parents
    for a, b in zip(first.joints, second.joints, strict=True):
        assert a.kind == b.kind
        np.testing.assert_allclose([a.x, a.y, a.origin], [b.x, b.y, b.origin], atol=1e-12)
    for a, b in zip(first.links, second.links, strict=True):
        np.testing.assert_allclose(list(a.values.values()), list(b.values.values()), atol=1e-12)
    np.testing.assert_allclose(first.tip, second.tip, atol=1e-12)


def test_a_robot_file_keeps_names_and_limits(urdf, tmp_path):
    robot = import_urdf(urdf)
    save_robot(robot, tmp_path / "robot.toml")
    assert load_robot(tmp_path / "robot.toml").joints == robot.joints


ARM = """<robot name="arm">
<link name="base"/><link name="upper"><inertial><mass value="2"/><origin xyz="0.5 0 0"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="hand"><inertial><mass value="1"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>
</inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="2" effort="30" velocity="0"/><dynamics damping="0.2" friction="0.3"/></joint>
<joint name="weld" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="1 0 0"/></joint>
</robot>"""


@pytest.fixture
def arm(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(ARM)
    return file


def test_fixed_joints_are_merged_and_hinges_added(arm):
    robot = import_urdf(arm, flexible=[1])
    assert (robot.links[0].m, robot.links[0].ms) == (3.0, (2.0, 0.0, 0.0))
    np.testing.assert_allclose(robot.links[0].J, (0.1, 0, 0, 1.6, 0, 1.6))
    assert robot.tip == (1.0, 0.0, 0.0)
    assert robot.parameters["joint1.coulomb"] == 0.3
    k = [robot.parameters[f"joint1.k[{i}]"] for i in (1, 2, 3)]  # about z, y and x: 10 Hz each
    np.testing.assert_allclose(k, (20 * np.pi) ** 2 * np.array([1.6, 1.6, 0.1]))
    assert import_urdf(arm, twist=[1]).coordinates == ("joint1.e", "joint1.eps[1]")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("revolute", "floating"), "joint shoulder is floating; only revolute"),
        (("<axis", '<mimic joint="weld"/><axis'), "joint shoulder mimics weld"),
        (("<axis", '<mimic joint="elbow"/><axis'), "joint shoulder mimics elbow, which is not there"),
        (("<axis", '<mimic joint="shoulder"/><axis'), "joint shoulder mimics itself"),
        (('xyz="0 0 1"', 'xyz="${direction}"'), "it is xacro, not yet URDF"),
        (("0 0 1", "0 0 0"), "axis of zero length"),
        (('"shoulder" type="revolute"', '"shoulder" type="fixed"'), "no joint that moves"),
        (("</robot>", ""), "cannot be read as URDF"),
        (('child link="hand"', 'child link="nothing"'), "cannot be read as URDF"),
        (
            ('<link name="base"/>', '<link name="b"/><link name="base"/>'),
            r"2 links have no parent \(b, base\)",
        ),
        (('parent link="base"', 'parent link="hand"'), "link hand hangs on itself"),
    ],
)
def test_what_cannot_be_read_is_explained(arm, change, words):
    arm.write_text(ARM.replace(*change))
    with pytest.raises(RobotError, match=words) as caught:
        import_urdf(arm)
    assert "\n" not in str(caught.value)


def test_an_empty_file_of_xacro_is_explained(arm):
    arm.write_text('<robot xmlns:xacro="http://wiki.ros.org/xacro"><!-- macros --></robot>')
    with pytest.raises(RobotError, match="it has no links; where xacro made it"):
        import_urdf(arm)


def test_an_impossible_link_is_not_exported(arm, tmp_path):
    robot = import_urdf(arm)
    for link in (Link(1.0, (0.0, 0.0, 0.0), (1.0, 0, 0, 0.1, 0, 0.1)), Link(0.0, (1.0, 0, 0), (1.0,) * 6)):
        with pytest.raises(RobotError, match="no rigid body"):
            export_urdf(replace(robot, links=(link,)), tmp_path / "x.urdf")
    with pytest.raises(RobotError, match="closed loops"):
        export_urdf(load_robot("parallelogram"), tmp_path / "x.urdf")
    assert not (tmp_path / "x.urdf").exists()


def test_the_commands(arm, tmp_path):
    def run(*words):
        return CliRunner().invoke(main, ["robots", *map(str, words)])

    done = run("import", arm, "-o", tmp_path / "arm.toml", "--twist", "1")
    assert (done.exit_code, "joints 1 shoulder" in done.output) == (0, True)
    done = run("export", tmp_path / "arm.toml", "-o", tmp_path / "out.urdf")
    assert "the flexible hinges of joints 1 are locked" in done.output
    assert pytest.approx(import_urdf(arm).links[0].J) == import_urdf(tmp_path / "out.urdf").links[0].J
    for words in (("--twist", "two"), ("--flexible", "1", "--twist", "1"), ("--twist", "7")):
        done = run("import", arm, "-o", tmp_path / "no.toml", *words)
        assert (done.exit_code, len(done.output.splitlines())) == (2, 1)


def test_quarter_turns_that_a_file_has_rounded_are_quarter_turns(tmp_path):
    """And no other angle is touched. Axes that are parallel but for 1e-10 told combinations of parameters."""
    link = """<link name="{}"><inertial><mass value="1"/>
        <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>"""
    joint = """<joint name="j{}" type="revolute"><parent link="{}"/><child link="{}"/>
        <origin xyz="0 0 0.4" rpy="{} 0 0"/><axis xyz="0 0 1"/></joint>"""
    turns = ("1.5708", "-1.570796327", "1.5")
    body = [link.format(name) for name in "abcd"]
    body += [
        joint.format(k, *pair, rpy)
        for k, (pair, rpy) in enumerate(zip(("ab", "bc", "cd"), turns, strict=True))
    ]
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{"".join(body)}</robot>')
    axes = np.array([joint.x for joint in import_urdf(tmp_path / "arm.urdf").joints])
    np.testing.assert_allclose(axes[0], [0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(axes[1], [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(axes[2], [0, -np.sin(1.5), np.cos(1.5)], atol=1e-12)
