"""Torques without their weight, on a wall, or with a constant; positions by other gears: by Pinocchio."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint
from studies.log_checks.swings import Motion, recorded, six_axes

from flexmodels.robot import Robot
from pyident.checks.check_log import check_log
from pyident.checks.defect import Defect
from pyident.logs.log import Log

ARM = six_axes()


def recorded_under(gravity: tuple[float, ...]) -> pd.DataFrame:
    return recorded(replace(ARM, gravity=gravity), Motion(), 3)


def defects(frame: pd.DataFrame, robot: Robot = ARM) -> dict[str, Defect]:
    return {d.kind: d for d in check_log(robot, Log.from_frame(frame, "a.csv"))}


@pytest.mark.parametrize(
    ("gravity", "words"),
    [((0.0, 0.0, 0.0), "with no gravity"), ((9.81, 0.0, 0.0), "gravity along +x"),
     ((0.0, 0.0, 9.81), "gravity along +z")],
)  # fmt: skip
def test_another_gravity_is_told(gravity, words):
    found = defects(recorded_under(gravity))
    assert words in found["gravity"].sentence


def test_weight_that_was_taken_out_is_told_where_friction_is_nearly_all():
    """Masses that are none hide that of a light arm: what the file's gravity leaves would need no word."""
    frames = {g: recorded_under((0.0, 0.0, g)) for g in (0.0, -9.81)}
    for frame in frames.values():
        for k in range(1, 7):
            speed = np.gradient(frame[f"joint{k}.e"], frame["time"])
            frame[f"joint{k}.tau"] += 30 * frames[0.0][f"joint{k}.tau"].std() * speed / speed.std()
    found = defects(frames[0.0])
    assert found["gravity"].severity == "doubtful"
    assert "with no gravity" in found["gravity"].sentence
    assert "gravity" not in defects(frames[-9.81])


def test_gravity_that_the_file_lacks_is_told():
    found = defects(recorded_under(ARM.gravity), replace(ARM, gravity=(0.0, 0.0, 0.0)))
    assert "gravity along -z" in found["gravity"].sentence


def test_that_of_the_file_is_not():
    assert not defects(recorded_under(ARM.gravity))


def test_a_constant_is_told_with_its_value_and_is_not_unrelated():
    plain = ARM.without_effect("offset")
    frame = recorded_under(ARM.gravity)
    frame["joint1.tau"] += 7 * frame["joint1.tau"].std()
    found = defects(frame, plain)
    assert "unrelated" not in found
    told = float(found["offset"].sentence.split("constant of ")[1].split()[0])
    assert told == pytest.approx(7 * frame["joint1.tau"].std(), rel=0.05)


def test_a_spring_that_outweighs_the_arm_is_not_unrelated():
    frame = recorded_under(ARM.gravity)
    angle = frame["joint1.e"] - frame["joint1.e"].mean()
    frame["joint1.tau"] += 10 * frame["joint1.tau"].std() * angle / angle.std()
    assert "unrelated" not in defects(frame)
    frame["joint1.tau"] = frame["joint1.tau"].sample(frac=1, random_state=1).to_numpy()
    assert "unrelated" in defects(frame)


@pytest.mark.parametrize(("ratio", "said"), [(1.6, "8/5"), (0.75, "3/4"), (1.01, "")])
def test_a_joint_with_the_teeth_of_another_gear_is_refused_with_the_ratio(ratio, said):
    """A hundredth is left to a diagnosis."""
    frame = recorded_under(ARM.gravity)
    found = defects(frame.assign(**{"joint2.e": frame["joint2.e"] / ratio}))
    assert ("ratio" in found) == bool(said)
    if said:
        assert f"joint2.e times {said} fits; correct its gear ratio" in found["ratio"].sentence


def test_what_is_touched_for_a_while_is_told_with_its_time_and_not_refused():
    """Of torques of another recording no part explains another."""
    t = 0.01 * np.arange(2400)
    slow, fast = 2 * np.pi * 0.37, 2 * np.pi * 0.83
    v = 0.9 * slow * np.cos(slow * t) + 0.5 * fast * np.cos(fast * t)
    a = -0.9 * slow**2 * np.sin(slow * t) - 0.5 * fast**2 * np.sin(fast * t)
    touched = 90 * np.sin(9.1 * t + 1) * (t > 7) * (t < 13)
    moving = {"time": t, "joint1.e": 0.9 * np.sin(slow * t) + 0.5 * np.sin(fast * t)}
    own = 0.8 * a + 3 * np.sign(v) + 2 * v
    found = defects(pd.DataFrame({**moving, "joint1.tau": own + touched}), one_joint())["unrelated"]
    assert found.severity == "doubtful"
    assert "but for those from 6.29 to 14.8 s after its start: was something touched" in found.sentence
    other = pd.DataFrame({**moving, "joint1.tau": 5 * np.sin(4.4 * t + 0.3) + 4 * np.cos(7.3 * t)})
    assert defects(other, one_joint())["unrelated"].severity == "gross"
