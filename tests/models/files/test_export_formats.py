"""Exports for other simulators: what is written, what is lost, and what the loss costs on a log."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from one_joint import one_joint
from servo_pendulum import pendulum

from flexmodels.experiment import identification
from flexmodels.files.five_numbers import export_five_numbers
from flexmodels.files.robot_file import load_robot, save_robot
from pyident.cli.main import main
from pyident.logs.log import Log, write_log
from pyident.simulation.fmu_runs import simulate_robot


def _pyident(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture(scope="module")
def stribeck(tmp_path_factory):
    """One joint with a law that no other format holds, and its own log."""
    folder = tmp_path_factory.mktemp("export")
    values = {"joint1.stribeck.level": 15.0, "joint1.stribeck.velocity": 4.0}
    robot = one_joint().with_effect(1, "stribeck").with_parameters(values)
    save_robot(robot, folder / "robot.toml")
    frame = simulate_robot(robot, identification(robot))
    write_log(Log(frame, "log"), folder / "log.parquet")
    return folder, robot, frame


@pytest.mark.parametrize("ending", [".urdf", ".xml", ".json"])
def test_what_a_format_loses_and_what_that_costs(stribeck, tmp_path, ending):
    folder, _, frame = stribeck
    out, machine = tmp_path / f"robot{ending}", tmp_path / "cost.json"
    log = folder / "log.parquet"
    ran = _pyident("robots", "export", folder / "robot.toml", "-o", out, "--log", log, "--json", machine)
    assert ran.exit_code == 0, ran.output
    assert "no place for" in ran.output
    assert "stribeck" in ran.output
    cost = json.loads(machine.read_text())["relative_error"][str(log)]
    # the law itself, evaluated from the log, is what is missing, but for the samples around reversals
    de = np.gradient(frame["joint1.e"], frame["time"])
    turning = np.abs(np.diff(np.sign(de), append=0)) + (np.abs(de) < 0.02 * np.std(de))
    away = np.convolve(turning, np.ones(5), "same") == 0
    law = 15.0 * np.sign(de) * np.exp(-((de / 4.0) ** 2))
    share = 100 * np.sqrt(np.mean(law[away] ** 2) / np.mean(frame["joint1.tau"][away] ** 2))
    assert cost["kept_percent"] > cost["all_laws_percent"] + share / 2
    if ending != ".urdf":  # which has no armature either
        assert cost["kept_percent"] == pytest.approx(np.hypot(share, cost["all_laws_percent"]), rel=0.2)


def test_five_numbers(stribeck, tmp_path):
    folder, robot, _ = stribeck
    out = tmp_path / "numbers.json"
    assert _pyident("robots", "export", folder / "robot.toml", "-o", out).exit_code == 0
    numbers = json.loads(out.read_text())["joint1"]
    values = robot.parameters
    assert numbers["armature"] == values["joint1.J_m"]
    assert numbers["friction"] == values["joint1.coulomb"]
    assert numbers["damping"] == values["joint1.viscous"]
    assert numbers["delay"] == 0.0


def test_the_delay_of_a_servo_is_one_of_the_five(tmp_path):
    robot = pendulum()
    assert robot.servo is not None
    robot = replace(robot, servo=replace(robot.servo, delay=0.007))
    export_five_numbers(robot, tmp_path / "numbers.json")
    assert json.loads((tmp_path / "numbers.json").read_text())["joint1"]["delay"] == 0.007


def test_an_mjcf_becomes_a_robot_file(tmp_path):
    pytest.importorskip("mujoco")
    from test_mjcf import FOLDER

    ran = _pyident("robots", "import", FOLDER / "legs.xml", "-o", tmp_path / "legs.toml")
    assert ran.exit_code == 0, ran.output
    assert "fixed base" in ran.output
    assert len(load_robot(tmp_path / "legs.toml").joints) == 9


def test_several_joints_of_a_urdf_stand_still_however_they_are_given(tmp_path):
    links = "".join(f'<link name="l{k}"><inertial><mass value="1"/></inertial></link>' for k in range(4))
    ends = '<parent link="l{1}"/><child link="l{0}"/><axis xyz="0 0 1"/>'
    joint = f'<joint name="j{{0}}" type="revolute">{ends}</joint>'
    joints = "".join(joint.format(k, k - 1) for k in (1, 2, 3))
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')
    for given in (("--fixed", "j2,j3"), ("--fixed", "j2", "--fixed", "j3")):
        out = tmp_path / "arm.toml"
        ran = _pyident("robots", "import", tmp_path / "arm.urdf", *given, "-o", out, "--overwrite")
        assert ran.exit_code == 0, ran.output
        assert [j.name for j in load_robot(out).joints] == ["j1"]


def test_an_unknown_ending_writes_nothing(stribeck, tmp_path):
    ran = _pyident("robots", "export", stribeck[0] / "robot.toml", "-o", tmp_path / "robot.sdf")
    assert ran.exit_code == 2
    assert ".urdf, .xml, .json" in ran.output
    assert not (tmp_path / "robot.sdf").exists()
