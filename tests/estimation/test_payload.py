"""A payload out of torques of Pinocchio and MuJoCo: a body is put on the last link, and found again."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

import pyident as pi
from flexmodels.files.mjcf.importer import import_mjcf
from flexmodels.files.robot_file import save_robot
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot
from pyident.cli.main import main
from pyident.logs.log import Log

MASS, CENTRE = 3.0, np.array([0.03, -0.05, 0.12])
TURN = Rotation.from_euler("xyz", [0.4, -0.3, 0.9])
PRINCIPAL = np.array([0.02, 0.03, 0.015])
J_CENTRE = TURN.as_matrix() @ np.diag(PRINCIPAL) @ TURN.as_matrix().T
ADDED = Link.of_centre(MASS, CENTRE, J_CENTRE)
ARM = Path(__file__).parents[1] / "robots" / "mjcf" / "arm.xml"
PERIOD = 0.01


def _swings(joints: int, seed: int, duration: float = 8.0):
    """time (N,), and q, dq, ddq (N, joints) along sums of four sines a joint."""
    rng, time = np.random.default_rng(seed), np.arange(0, duration, PERIOD)
    q, dq, ddq = (np.zeros((len(time), joints)) for _ in range(3))
    for k in range(joints):
        for harmonic in range(1, 5):
            omega, phase = 2 * np.pi * 0.25 * harmonic * rng.uniform(0.9, 1.1), rng.uniform(0, 2 * np.pi)
            size = rng.uniform(0.3, 0.8) / harmonic
            q[:, k] += size * np.sin(omega * time + phase)
            dq[:, k] += size * omega * np.cos(omega * time + phase)
            ddq[:, k] -= size * omega**2 * np.sin(omega * time + phase)
    return time, q, dq, ddq


def _log(time: np.ndarray, q: np.ndarray, tau: np.ndarray, source: str) -> Log:
    columns = {"time": time}
    columns |= {f"joint{k + 1}.e": q[:, k] for k in range(q.shape[1])}
    columns |= {f"joint{k + 1}.tau": tau[:, k] for k in range(q.shape[1])}
    return Log(pd.DataFrame(columns), source)


@pytest.fixture(scope="module")
def logs():
    """Pinocchio's, with friction and noise: of the arm alone, and of the arm with the body; other motions."""
    six_axis_logs = pytest.importorskip("six_axis_logs")
    robot = six_axis_logs.arm()
    own = robot.links[-1]
    whole = Link(
        own.m + ADDED.m,
        tuple(a + b for a, b in zip(own.ms, ADDED.ms, strict=True)),
        tuple(a + b for a, b in zip(own.J, ADDED.J, strict=True)),
    )
    loaded = replace(robot, links=(*robot.links[:-1], whole))
    return robot, six_axis_logs.made(robot, 1, duration=15.0), six_axis_logs.made(loaded, 2, duration=15.0)


@pytest.fixture(scope="module")
def load(logs):
    return pi.payload(*logs)


def test_the_ten_parameters_lie_within_their_intervals(load):
    true = np.array(list(ADDED.values.values()))
    off = (load.carried.free - true) / load.carried.std
    assert load.carried.rank == 10
    assert (np.abs(off) < 4).all(), off
    assert np.sqrt(np.mean(off**2)) < 2
    assert load.mass == pytest.approx(MASS, rel=0.02)
    np.testing.assert_allclose(load.centre, CENTRE, atol=0.003)


def test_what_is_written_is_a_body_and_the_robot_carries_it(load, logs):
    m, a, b, c, xx, xy, xz, yy, yz, zz = load.carried.consistent
    half = (xx + yy + zz) / 2
    body = [[half - xx, -xy, -xz, a], [-xy, half - yy, -yz, b], [-xz, -yz, half - zz, c], [a, b, c, m]]
    assert np.linalg.eigvalsh(body).min() > 0
    assert load.robot.links[-1].m == pytest.approx(logs[0].links[-1].m + m)
    assert load.robot.links[:-1] == logs[0].links[:-1]


def test_a_body_that_mujoco_attaches():
    """Its frames, offsets and signs are MuJoCo's. Torques are those of instants, held by no controller."""
    mujoco = pytest.importorskip("mujoco")
    robot = replace(import_mjcf(ARM).robot, controller=None)

    def recorded(body: bool, seed: int):
        spec = mujoco.MjSpec.from_file(str(ARM))
        for joint in spec.joints:
            joint.frictionloss, joint.limited = 0.0, False  # which are soft in MuJoCo
        for geom in spec.geoms:
            geom.contype = geom.conaffinity = 0
        if body:
            x, y, z, w = TURN.as_quat()
            tool = spec.body("w3").add_body(pos=[0.01, 0.02, 0.03], quat=[0.8, 0.0, 0.6, 0.0])
            tool.mass, tool.ipos, tool.iquat, tool.inertia = MASS, CENTRE, [w, x, y, z], PRINCIPAL
            tool.explicitinertial = True
        model = spec.compile()
        data = mujoco.MjData(model)
        time, q, dq, ddq = _swings(6, seed)
        tau = np.zeros_like(q)
        for i in range(len(time)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q[i], dq[i], ddq[i]
            mujoco.mj_inverse(model, data)
            tau[i] = data.qfrc_inverse
        data.qpos[:] = 0
        mujoco.mj_forward(model, data)
        R = data.ximat[-1].reshape(3, 3)
        centre, J = data.xipos[-1] - data.xanchor[-1], R @ np.diag(model.body_inertia[-1]) @ R.T
        noise = 1e-3 * np.random.default_rng(seed).standard_normal(tau.shape)
        return _log(time, q, tau + noise, "MuJoCo"), Link.of_centre(MASS, centre, J)

    (empty, _), (loaded, true) = recorded(False, 1), recorded(True, 2)
    load = pi.payload(robot, empty, loaded)
    assert load.carried.rank == 10
    off = load.carried.free - list(true.values.values())
    assert np.sqrt(np.mean((off / load.carried.std) ** 2)) < 2
    assert np.abs(off).max() < 1e-3
    np.testing.assert_allclose(load.carried.consistent, list(true.values.values()), atol=1e-3)


def test_what_one_upright_hinge_tells():
    """Closed form: tau = (J_zz + J_m) ddq. Gravity does nothing, so that J_zz is all that can be known."""
    laws = {"motor_inertia": {"J_m": 0.5}, "coulomb": {"coulomb": 0.0}, "viscous": {"viscous": 0.0}}
    joint = Joint("revolute", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), False, laws)
    link = Link(2.0, (1.0, 0.0, 0.0), (0.1, 0.0, 0.0, 0.6, 0.0, 0.6))
    robot = Robot("hinge", (joint,), (link,), tip=(1.0, 0.0, 0.0))

    def recorded(J: float, seed: int) -> Log:
        time, q, _, ddq = _swings(1, seed)
        noise = 1e-3 * np.random.default_rng(seed).standard_normal(q.shape)
        return _log(time, q, J * ddq + noise, "closed form")

    load = pi.payload(robot, recorded(1.1, 1), recorded(1.35, 2))
    known = np.isfinite(load.carried.std)
    assert known.tolist() == [False] * 9 + [True]
    assert load.carried.rank == 1
    assert abs(load.carried.free[-1] - 0.25) < 4 * load.carried.std[-1] < 0.01
    assert "1 of ten" in load.summary()
    assert load.to_dict()["parameters"]["m"]["std"] is None


def test_the_robot_files_own_values_do_not_matter(load, logs):
    robot, empty, loaded = logs
    other = robot.with_parameters({f"link{k}.m": 1.0 for k in range(1, 7)})
    again = pi.payload(other, empty, loaded).carried
    np.testing.assert_allclose(again.free, load.carried.free, rtol=1e-6, atol=1e-9)


def test_no_payload_is_none(logs):
    robot, empty, _ = logs
    short = Log(empty.frame.head(600), "short")
    none = pi.payload(robot, short, short)
    np.testing.assert_allclose(none.carried.free, 0, atol=1e-6)
    assert none.headline().startswith("these logs tell no load from none")
    assert "from its joint" not in none.summary()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_another_recording_of_the_arm_alone_carries_nothing(logs, seed):
    robot, empty, loaded = logs
    rng = np.random.default_rng(seed)
    half = len(empty.frame) // 2
    noisy = empty.frame.copy()
    for name in robot.torques:
        noisy[name] += 0.05 * rng.standard_normal(len(noisy))
    parts = [Log(part.reset_index(drop=True), "part") for part in (noisy[:half], noisy[half:])]
    assert pi.payload(robot, *parts).carried.none_fits
    assert not pi.payload(robot, empty, loaded).carried.none_fits


def test_it_says_in_which_axes_and_what_is_written(load):
    """An arm out of a URDF has no friction yet."""
    said = " ".join(load.summary().split())
    assert "axes that turn with the link and are parallel to the base's in the zero pose" in said
    assert "Friction and rotor inertias are 0 in it: identify the model" in load.not_identified
    known = replace(load, model=load.model.with_parameters({"joint1.coulomb": 2.0}))
    assert known.not_identified.endswith("was not identified here")


def test_the_command(tmp_path, logs):
    robot, empty, loaded = logs
    pi.write_log(empty, tmp_path / "empty.parquet")
    pi.write_log(loaded, tmp_path / "loaded.parquet")
    save_robot(robot, tmp_path / "arm.toml")
    words = [tmp_path / name for name in ("arm.toml", "empty.parquet", "loaded.parquet")]
    words += ["-o", tmp_path / "new.toml", "--json", tmp_path / "new.json"]
    result = CliRunner().invoke(main, ["payload", *map(str, words)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    told = json.loads((tmp_path / "new.json").read_text())
    assert told["mass_kg"] == pytest.approx(MASS, rel=0.05)
    assert told["axes"] == "the link's: parallel to the base's in the zero pose"
    assert "everything else, friction, too, is the model's own" in " ".join(result.output.split())
    added = pi.load_robot(tmp_path / "new.toml").links[-1].m - robot.links[-1].m
    assert added == pytest.approx(told["mass_kg"])
