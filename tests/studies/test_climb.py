"""How the XL330 study chooses its laws, with errors that are made up: no simulation."""

from pathlib import Path
from types import SimpleNamespace

import pyident as pi
from pyident.sweep.studies import find_study

find_study("xl330")  # from then on its files can be imported
from pyident.sweep.studies.xl330 import climb  # noqa: E402  # pyright: ignore[reportMissingImports]

START = Path(__file__).parents[2] / "studies" / "xl330" / "start.toml"
RECORDINGS = {f"{motion}_kp{gain}": f"{motion}_kp{gain}" for motion in "abcd" for gain in (100, 800)}
LOAD, IRON, SLOW, SQUARE = climb.LAWS


class MadeUp:
    """Fits that change nothing; an error for each set of laws."""

    def __init__(self, errors):
        self.errors, self.pairs, self.fitted = errors, [], []

    def fit(self, robot, recordings, rounds=20):
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
