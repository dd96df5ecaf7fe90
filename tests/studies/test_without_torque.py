"""Torques dropped from a generated log: what is named, and what the result says of the torque's origin."""

import numpy as np
import pytest
from studies.hidden_effect.blind import notes_of, solve_all
from studies.hidden_effect.generator.laws import LAWS
from studies.hidden_effect.generator.logs_and_key import cases_of, generate
from studies.hidden_effect.scoring import Scored, unseal
from studies.without_torque import study
from studies.without_torque.study import DRIVE, MOTOR, rows, torqueless
from two_link_logs import planned

from flexmodels.files.robot_file import load_robot
from pyident.logs.log import read_log
from pyident.refinement.loop_torque import UNSEEN

STRIBECK, RIPPLE = ("stribeck", 2), ("torque_ripple", 2)


@pytest.fixture(scope="module")
def robot_file(tmp_path_factory):
    """Two links, with an experiment: a case takes some seconds."""
    return planned(tmp_path_factory.mktemp("robot"))


def test_the_table_counts_what_it_says():
    def case(truth, verdict, *ties):
        return Scored("a", "single" if truth else "null", truth, verdict, ties)

    cases = [
        case((STRIBECK,), "missing_effect", (STRIBECK,)),
        case((STRIBECK,), "cannot_tell", (RIPPLE, STRIBECK), (RIPPLE,)),
        case((STRIBECK,), "unexplained", (STRIBECK,)),
        case((("torque_delay", 2),), "unexplained"),
        case((), "nothing_detectable"),
    ]
    found = {row["what"]: row["value"] for row in rows(cases, [True, True, True, False, True])}
    assert [text.split(";")[0] for text in found.values()] == [
        "67 % (2 of 3",
        "67 % (2 of 3",
        "33 % (1 of 3",
        "0 % (0 of 1",
        "0 % (0 of 1",
        "80 % (4 of 5",
        "0",
    ]


def test_every_law_is_one_that_the_generator_hides():
    assert set(MOTOR) | set(DRIVE) <= {name for name, law in LAWS.items() if law.catalogue}
    assert not set(MOTOR) & set(DRIVE)


@pytest.mark.slow
def test_the_law_is_named_without_the_torque(robot_file, tmp_path):
    cases = cases_of(["load_dependent_friction@1"], seed=11, robot=robot_file)
    solve_all(cases, tmp_path, 20, lambda _: None, robot_file, torqueless)
    found, name = unseal(tmp_path, cases[0].id), cases[0].id
    assert found.failure == ""
    assert found.first_tie[:1] == found.truth
    assert sum(UNSEEN in note for note in notes_of(tmp_path, name)) == 3  # of three logs
    shown = study.report(cases, tmp_path)
    assert {row["what"]: row["value"] for row in shown.rows}["says what it can no longer see"].startswith(
        "100 %"
    )


def test_what_the_diagnosis_sees_has_no_torque(robot_file, tmp_path):
    """But the one that the loop tells, which is the recorded one up to a constant of some percent."""
    (case,) = cases_of(["null"], seed=11, robot=robot_file)
    paths = generate(case, tmp_path)
    robot = load_robot(robot_file)
    seen = torqueless(tmp_path / "logs" / case.id, robot)
    true = read_log(paths[0]).signals(robot.torques)
    off = seen.logs[0].signals(robot.torques) - true
    assert np.all(off.std(axis=0) < 1e-6 * true.std(axis=0))
    assert np.all(np.abs(off.mean(axis=0)) < 0.1 * true.std(axis=0))
    with pytest.raises(KeyError):
        study._bare(read_log(paths[0]), robot).signals(robot.torques)
