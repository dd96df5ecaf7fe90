"""A servo inside the FMU against its law written again: step by step here, and integrated by SciPy."""

import re

import numpy as np
import pytest
from servo_pendulum import by_hand, pendulum

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.inputs import Experiment
from flexmodels.mechanics.plant import equations
from flexmodels.named_values import settable, with_settings
from flexmodels.robot import RobotError


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    path = tmp_path_factory.mktemp("servo") / "pendulum.fmu"
    with LoadedFmu(export_fmu(equations(pendulum()), path)) as loaded:
        yield loaded


def _commands(seconds: float = 2.0) -> Experiment:
    time = np.arange(round(seconds / 0.005) + 1) * 0.005
    reference = (0.9 * np.sin(2 * np.pi * 0.8 * time) + 0.3 * (time > 1.0))[:, None]
    on = np.where((time > 1.3) & (time < 1.6), 0.0, 1.0)[:, None]
    return Experiment(time, reference, np.zeros_like(reference), on, np.array([0.2]))


def test_the_loop_is_what_its_description_says(fmu):
    """Delay between samples, dead band, limit, integral and switch at once."""
    plan = _commands()
    frame = fmu.simulate(plan)
    np.testing.assert_allclose(frame["joint1.e"], by_hand(plan), rtol=0, atol=2e-4)
    off = (plan.time > 1.32) & (plan.time < 1.58)
    assert (frame["joint1.tau"][off] == 0).all()


def test_torque_from_a_log_is_the_torque_in_the_fmu(fmu):
    """Without integral, whose samples a log does not hold; half a sample of the loop apart."""
    plan = _commands()
    robot = with_settings(pendulum(), {"servo.ki": 0.0, "servo.dead_band": 0.0})
    frame = fmu.simulate(plan, settable(robot))
    e = frame[["joint1.e"]].to_numpy()
    de = np.gradient(e, plan.time, axis=0)
    tau = robot.servo.torque(plan.reference, e, de, plan.on, plan.time)  # pyright: ignore[reportArgumentType, reportOptionalMemberAccess]
    steady = np.abs(plan.time[:, None] - np.array([0.0, 1.0, 1.0125, 1.3, 1.6])).min(axis=1) > 0.03
    difference = (tau[:, 0] - frame["joint1.tau"])[steady]
    assert np.sqrt(np.mean(difference**2)) < 0.01 * frame["joint1.tau"].std()


def test_settings_by_name(tmp_path):
    robot = pendulum()
    save_robot(robot, tmp_path / "servo.toml")
    assert load_robot(tmp_path / "servo.toml").servo == robot.servo
    changed = with_settings(robot, {"servo.kp": 400.0, "servo.delay": 0.001, "joint1.viscous": 0.5})
    assert changed.servo.kp == (400.0,)  # pyright: ignore[reportOptionalMemberAccess]
    assert changed.servo.delay == 0.001  # pyright: ignore[reportOptionalMemberAccess]
    assert changed.parameters["joint1.viscous"] == 0.5
    with pytest.raises(RobotError, match=r"no parameter servo\.kq; it has servo\.R, .*servo\.delay"):
        with_settings(robot, {"servo.kq": 1.0})


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("R = [0.0]", r"servo\.R\[1\] = 0\.0 must be above 0"),
        ("delay = 1.0", r"servo\.delay = 1 s is over 250 samples"),
        ('unknown = ["kz"]', r"servo\.unknown\[1\] must be kp, .* or delay, not 'kz'"),
        ("kp = [1.0, 2.0]", r"servo\.kp must be 1 numbers"),
        ("speed = 1.0", r"servo\.speed is not a known key"),
    ],
)
def test_a_wrong_servo_is_named_by_its_key(tmp_path, line, words):
    save_robot(pendulum(), tmp_path / "servo.toml")
    text = (tmp_path / "servo.toml").read_text()
    key = line.split(" =")[0]
    without = re.sub(rf"\n{key} = (\[.*?\]|[^\[\n]*)(?=\n)", "", text, flags=re.S)
    (tmp_path / "servo.toml").write_text(without.replace("[servo]", f"[servo]\n{line}"))
    with pytest.raises(RobotError, match=words):
        load_robot(tmp_path / "servo.toml")
