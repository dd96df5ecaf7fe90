"""A payload out of Pinocchio's torques: a body is put on its last link, and found again."""

import json
from dataclasses import replace

import numpy as np
import pytest
import six_axis_logs
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

import pyident as pi
from flexmodels.files.robot_file import save_robot
from flexmodels.link import Link
from pyident.cli.main import main

MASS, CENTRE = 3.0, np.array([0.03, -0.05, 0.12])
TURN = Rotation.from_euler("xyz", [0.4, -0.3, 0.9]).as_matrix()
ADDED = Link.of_centre(MASS, CENTRE, TURN @ np.diag([0.02, 0.03, 0.015]) @ TURN.T)


@pytest.fixture(scope="module")
def logs():
    """Of the arm alone, and of the arm with the body; other motions."""
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
def found(logs):
    return pi.payload(*logs)


def test_the_ten_parameters_lie_within_their_intervals(found):
    true = np.array(list(ADDED.values.values()))
    off = (found.carried.free - true) / found.carried.std
    assert (np.abs(off) < 4).all(), off
    assert np.sqrt(np.mean(off**2)) < 2
    assert found.mass == pytest.approx(MASS, rel=0.02)
    np.testing.assert_allclose(found.centre, CENTRE, atol=0.003)


def test_what_is_written_is_a_body_and_the_robot_carries_it(found, logs):
    m, a, b, c, xx, xy, xz, yy, yz, zz = found.carried.consistent
    half = (xx + yy + zz) / 2
    body = [[half - xx, -xy, -xz, a], [-xy, half - yy, -yz, b], [-xz, -yz, half - zz, c], [a, b, c, m]]
    assert np.linalg.eigvalsh(body).min() > 0
    assert found.robot.links[-1].m == pytest.approx(logs[0].links[-1].m + m)
    assert found.robot.links[:-1] == logs[0].links[:-1]


def test_the_robot_files_own_values_do_not_matter(logs):
    robot, empty, loaded = logs
    other = robot.with_parameters({f"link{k}.m": 1.0 for k in range(1, 7)})
    by = [pi.payload(one, empty, loaded, estimator="wls").carried.free for one in (robot, other)]
    np.testing.assert_allclose(by[0], by[1], rtol=1e-6, atol=1e-9)


def test_no_payload_is_none(logs):
    robot, empty, _ = logs
    none = pi.payload(robot, empty, empty, estimator="wls").carried
    np.testing.assert_allclose(none.free, 0, atol=1e-6)


def test_the_command(tmp_path, logs):
    robot, empty, loaded = logs
    pi.write_log(empty, tmp_path / "empty.parquet")
    pi.write_log(loaded, tmp_path / "loaded.parquet")
    save_robot(robot, tmp_path / "arm.toml")
    arguments = [str(tmp_path / name) for name in ("arm.toml", "empty.parquet", "loaded.parquet")]
    arguments += [
        "--estimator",
        "wls",
        "-o",
        str(tmp_path / "new.toml"),
        "--json",
        str(tmp_path / "new.json"),
    ]
    result = CliRunner().invoke(main, ["payload", *arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    told = json.loads((tmp_path / "new.json").read_text())
    assert told["mass_kg"] == pytest.approx(MASS, rel=0.05)
    added = pi.load_robot(tmp_path / "new.toml").links[-1].m - robot.links[-1].m
    assert added == pytest.approx(told["mass_kg"])
