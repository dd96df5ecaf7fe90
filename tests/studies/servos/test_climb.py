"""How the XL330 study chooses its laws, with errors that are made up, and what it writes: no simulation."""

from pathlib import Path
from types import SimpleNamespace

import pytest

import pyident as pi
from flexmodels.files.urdf.exporter import export_urdf
from flexmodels.robot import RobotError
from pyident.sweep.studies import find_study

find_study("xl330")  # from then on its files can be imported
from pyident.sweep.studies.xl330 import climb  # noqa: E402  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.xl330.study import as_a_body  # noqa: E402  # pyright: ignore[reportMissingImports]

START = Path(__file__).parents[3] / "studies" / "xl330" / "start.toml"
RECORDINGS = {f"{motion}_kp{gain}": f"{motion}_kp{gain}" for motion in "abcd" for gain in (100, 800)}
LOAD, IRON, SLOW, SQUARE = climb.LAWS


class MadeUp:
    """Fits that change nothing; an error for each set of laws."""

    def __init__(self, errors):
        self.errors, self.pairs, self.fitted = errors, [], []

    def fit(self, robot, recordings):
        self.fitted = recordings
        return SimpleNamespace(robot=robot)

    def error(self, robot, recordings):
        self.pairs.append((self.fitted, recordings))
        names = {law for law in robot.joints[0].values if law in climb.LAWS}
        names |= {IRON} & set(robot.servo.unknown)
        return self.errors.get(frozenset(names), 9.0)


def _climbed(*errors):
    """errors: of the rungs, from the lowest on."""
    fits = MadeUp({frozenset(climb.LAWS[:number]): error for number, error in enumerate(errors)})
    return climb.climbed(pi.load_robot(START), RECORDINGS, fits, lambda _: None), fits


def test_the_lowest_rung_within_a_tenth_of_the_best_is_taken():
    chosen, _ = _climbed(3.0, 2.0, 1.05, 1.0, 1.2)
    assert chosen.laws == f"{LOAD}, {IRON}"
    assert chosen.robot.servo.unknown[-1] == IRON
    assert chosen.robot.servo.saturation[0] > 0


def test_a_rung_that_does_not_help_hides_none_above():
    chosen, _ = _climbed(3.0, 3.5, 3.4, 1.0, 2.0)
    assert chosen.laws == f"{LOAD}, {IRON}, {SLOW}"
    assert SQUARE not in chosen.robot.joints[0].values


def test_no_law_where_none_helps():
    chosen, _ = _climbed(3.0, 2.8, 2.75, 2.9, 9.0)
    assert chosen.laws == "no further law"
    assert len(chosen.told) == len(climb.LAWS) + 2


def test_what_is_judged_was_not_fitted_and_all_is_judged():
    _, fits = _climbed(3.0, 2.0, 1.0, 1.0, 1.0)
    for fitted, judged in fits.pairs:
        motions = [{name[0] for name in names} for names in (fitted, judged)]
        assert motions[0].isdisjoint(motions[1])
        assert set(fitted) | set(judged) == set(RECORDINGS)
    assert {name for _, judged in fits.pairs for name in judged} == set(RECORDINGS)


def test_the_drive_that_is_chosen_can_be_written(tmp_path):
    chosen, _ = _climbed(3.0, 2.0, 1.0, 1.0, 1.0)
    pi.save_robot(chosen.robot, tmp_path / "model.toml")
    assert pi.load_robot(tmp_path / "model.toml").servo == chosen.robot.servo


def test_the_written_pendulum_is_a_body_that_moves_as_before(tmp_path):
    """Its weight moved sideways by the fit; the inertia about the hinge, motor included, is as before."""
    start = pi.load_robot(START)
    fitted = start.with_parameters({"link1.ms[x]": -0.0013})
    with pytest.raises(RobotError, match="no rigid body"):
        export_urdf(fitted, tmp_path / "not.urdf")
    written = as_a_body(fitted, start)
    export_urdf(written, tmp_path / "pendulum.urdf")
    about = ("link1.J[yy]", "joint1.J_m")  # the hinge turns about y
    whole = [sum(robot.parameters[name] for name in about) for robot in (fitted, written)]
    assert whole[1] == pytest.approx(whole[0], rel=1e-12)
    assert written.links[0].ms == pytest.approx(fitted.links[0].ms, rel=1e-12)
