"""Laws that users write, in files of their own."""

import numpy as np
import pytest
from test_effects import TWO_LINK, experiment, law_forces, simulated

from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.robot import RobotError

OWN = """
from sympy import Abs, Symbol
from flexmodels.effects.effect import Effect, Parameter, State
from flexmodels.effects.signals import de, e

level, travel = Parameter("level", "N.m", lower=0), Parameter("travel", "rad", start=0.01, grid=(0.01, 0.03))
bend = Symbol("bend", real=True)
own = Effect(
    name="own_friction", title="Friction from elsewhere", forces={e: level.symbol * bend},
    states=(State("bend", (de - Abs(de) * bend) / travel.symbol),),
    parameters=(level, travel), citation="own",
)
"""


def test_a_law_from_outside_the_package(tmp_path):
    (tmp_path / "own.py").write_text(OWN)
    text = 'effects = ["own.py"]\n' + TWO_LINK.read_text()
    text = text.replace("[[link]]", "[joint.effects.own_friction]\nlevel = 8.0\ntravel = 0.02\n\n[[link]]", 1)
    (tmp_path / "robot.toml").write_text(text)
    robot = load_robot(tmp_path / "robot.toml", allow_effects=True)
    assert robot.parameters["joint2.own_friction.travel"] == 0.02
    assert "joint2.own_friction.travel" not in robot.linear_parameters
    (tmp_path / "elsewhere").mkdir()
    save_robot(robot, tmp_path / "elsewhere" / "copy.toml")
    assert load_robot(tmp_path / "elsewhere" / "copy.toml", allow_effects=True).parameters == robot.parameters
    log, motion, _ = simulated(robot, tmp_path, experiment(0.4))
    own = law_forces(robot, motion, 2, "own_friction")[:, 1]
    np.testing.assert_allclose(own, 8.0 * log["joint2.own_friction.bend"], atol=0.05)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('name="own_friction"', 'name="stribeck"', "effect stribeck is in the catalogue already"),
        ("level.symbol * bend", "level.symbol * bend * wind", "cannot be read .NameError"),
        ("(de - Abs(de) * bend)", "(de - Abs(de) * bend**2)", "the rate of bend must be affine in it"),
        (", grid=(0.01, 0.03)", "", "own_friction is not linear in its parameter travel"),
        ("own = Effect", "own = dict", "defines no Effect"),
    ],
)
def test_a_wrong_law_is_explained(old, new, words, tmp_path):
    assert old in OWN
    (tmp_path / "own.py").write_text(OWN.replace(old, new))
    (tmp_path / "robot.toml").write_text('effects = ["own.py"]\n' + TWO_LINK.read_text())
    with pytest.raises(RobotError, match=words) as caught:
        load_robot(tmp_path / "robot.toml", allow_effects=True)
    assert "\n" not in str(caught.value)
