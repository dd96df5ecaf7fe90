"""Laws of users: refused with a reason, shown before a robot uses them, and theirs alone."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
import sympy
from click.testing import CliRunner
from two_link_logs import TWO_LINK, two_link

from flexmodels.effects import BASE, CATALOGUE
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.effects.functions import FUNCTIONS
from flexmodels.effects.law_names import EffectError
from flexmodels.effects.signals import de, e
from flexmodels.files.robot_file import load_robot
from pyident.cli.main import main

LEVEL = Parameter("level", "N.m")
OWN = """
from sympy import {function}
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.effects.signals import de, e

from pathlib import Path
Path({witness!r}).write_text(Path({witness!r}).read_text() + "ran")
level = Parameter("level", "N.m")
own = Effect(name="own_law", title="Own", forces={{e: level.symbol * {function}(de)}}, parameters=(level,),
             citation="none")
"""


def law(expression: sympy.Expr, *more: Parameter) -> Effect:
    return Effect(
        name="own_law", title="Own", forces={e: expression}, parameters=(LEVEL, *more), citation="none"
    )


@pytest.mark.parametrize("function", [sympy.asinh, sympy.log, sympy.atan, sympy.Heaviside, sympy.gamma])
def test_a_function_that_the_plant_has_not_is_refused_by_its_name(function):
    with pytest.raises(EffectError, match=f"own_law uses {function.__name__}.*sin, cos"):
        law(LEVEL.symbol * function(de)).check()


def test_branches_and_unknown_functions_are_refused():
    for bad in (sympy.Piecewise((de, de > 0), (0, True)), sympy.Function("mine")(de)):
        with pytest.raises(EffectError, match="uses"):
            law(LEVEL.symbol * bad).check()


def test_a_law_that_is_no_number_is_refused():
    with pytest.raises(EffectError, match="no number"):
        law(LEVEL.symbol * de * sympy.zoo).check()


def test_a_law_is_sized_by_one_of_its_parameters():
    own = replace(law(LEVEL.symbol * de), sized_by="width")
    with pytest.raises(EffectError, match="no parameter width"):
        own.check()


@pytest.mark.parametrize("function", FUNCTIONS)
def test_every_documented_function_is_known_and_has_its_value(function):
    arguments = (de, 1) if function in ("Min", "Max") else (de**2 + 1,) if function == "sqrt" else (de,)
    own = law(LEVEL.symbol * getattr(sympy, function)(*arguments))
    own.check()
    numpys = {"Min": np.minimum, "Max": np.maximum, "Abs": np.abs}.get(function, getattr(np, function, None))
    assert numpys is not None
    for speed in (-1.7, 0.6, 2.3):
        expected = numpys(*(float(sympy.sympify(a).subs(de, speed)) for a in arguments))
        assert float(own.columns["level"][e].subs(de, speed)) == pytest.approx(expected, rel=1e-12)


def test_every_law_that_ships_passes_its_own_check():
    for effect in CATALOGUE.values():
        effect.check()
    assert {n for n, effect in CATALOGUE.items() if effect.order} == {
        "torque_ripple",
        "kinematic_error",
        "position_dependent_friction",
    }


def test_a_period_may_have_any_name_and_is_nonlinear():
    teeth = Parameter("teeth", "1", start=3.0, grid=(3.0, 5.0), periodic=True)
    found = law(LEVEL.symbol * sympy.sin(teeth.symbol * e), teeth)
    found.check()
    assert found.order is teeth
    with pytest.raises(EffectError, match="periodic"):
        law(LEVEL.symbol * de, replace(LEVEL, name="b", periodic=True)).check()


def test_the_catalogue_cannot_be_changed():
    with pytest.raises(TypeError):
        CATALOGUE["own_law"] = law(LEVEL.symbol * de)  # pyright: ignore
    assert set(BASE) < set(CATALOGUE)


def written(folder, function="tanh"):
    witness = folder / "witness"
    witness.write_text("")
    (folder / "own.py").write_text(OWN.format(function=function, witness=str(witness)))
    text = 'effects = ["own.py"]\n' + TWO_LINK.read_text()
    text = text.replace("[[link]]", "[joint.effects.own_law]\nlevel = 8.0\n\n[[link]]", 1)
    (folder / "robot.toml").write_text(text)
    return witness


def test_a_robot_that_travels_takes_its_laws_along_and_runs_no_file(tmp_path):
    witness = written(tmp_path)
    robot = load_robot(tmp_path / "robot.toml", allow_effects=True)
    assert witness.read_text() == "ran"
    content = pickle.dumps(robot)
    (tmp_path / "own.py").unlink()
    again = pickle.loads(content)
    assert witness.read_text() == "ran"
    (own,) = (law for joint in again.joints for law in joint.effects if law.name == "own_law")
    assert own.forces == robot.catalogue["own_law"].forces
    assert "own_law" not in two_link().catalogue
    assert "own_law" not in CATALOGUE


def test_the_command_checks_and_shows_a_file(tmp_path):
    written(tmp_path)
    shown = CliRunner().invoke(main, ["effects", "--file", str(tmp_path / "own.py")])
    assert shown.exit_code == 0, shown.output
    assert "own_law" in shown.output
    assert "tanh(de)" in shown.output
    written(tmp_path, "asinh")
    refused = CliRunner().invoke(main, ["effects", "--file", str(tmp_path / "own.py")])
    assert refused.exit_code == 2
    assert "own_law uses asinh" in refused.output
    assert CliRunner().invoke(main, ["effects", "--file", str(tmp_path / "none.py")]).exit_code == 2
