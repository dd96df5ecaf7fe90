"""A part of the test bench of the checks: every eighth kind of wrong log, each on one robot in turn."""

import pytest

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes the logs")

from pyident.sweep.studies.log_checks import study  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.log_checks.good_logs import HONEST, scara  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.log_checks.lacking import lacking  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.log_checks.swings import Motion, recorded, six_axes  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.log_checks.wrong_logs import KINDS  # pyright: ignore[reportMissingImports]

from pyident.checks.check_log import check_log
from pyident.logs.log import Log

SHARE = 0.95
FEWEST = 60  # kinds


def test_there_are_enough_kinds():
    assert len(KINDS) >= FEWEST


def test_grossly_wrong_logs_are_flagged(data):
    """The whole bench: pyident study log_checks."""
    bases = [(robot, log) for robot, log in study.sound_bases()]
    assert len(bases) == 3
    flagged = []
    for i, (name, change) in enumerate(list(KINDS.items())[::8]):
        robot, log = bases[i % 3]
        frame = change(robot, log.frame.copy())
        if frame is not None:
            flagged.append((study.outcome(robot, frame, "log.csv")[0] != "missed", name))
    missed = [name for found, name in flagged if not found]
    assert len(missed) <= (1 - SHARE) * len(flagged), missed


@pytest.mark.parametrize("name", [*list(HONEST)[::3], "as it is", "two axes at rest", "50 Hz"])
def test_honest_logs_are_not_flagged(data, name):
    motions = {"two axes at rest": Motion(standing=(2, 4)), "smooth start": Motion(rest=3.0, duration=15.0),
               "50 Hz": Motion(period=0.02, duration=30.0)}  # fmt: skip
    motion = motions.get(name, Motion(speed=0.5))
    for robot in (six_axes(), scara()):
        assert robot is not None
        if motion.period == 0.02 and robot.controller:
            continue
        frame = HONEST.get(name, lambda f: f)(recorded(robot, motion, 70))
        assert check_log(robot, Log(frame, "log.csv")) == (), name


def test_an_axis_at_rest_is_exchanged_with_none(data):
    """What moves it may be another axis, and its brake holds anything."""
    at_rest = Motion(speed=0.224, highest=1.53, duration=31.9, period=0.008, standing=(4,))
    slow = Motion(speed=0.161, highest=0.92, duration=18.6, period=0.01, standing=(1, 2, 3))
    for robot, motion, seed in ((six_axes(), at_rest, 3006), (scara(), slow, 7034)):
        assert robot is not None
        assert check_log(robot, Log(recorded(robot, motion, seed), "log.csv")) == ()


@pytest.mark.slow
def test_a_strong_law_that_a_model_lacks_is_not_refused(data):
    """Hoses and end stops were told as joints of the wrong sign or order, bristles as late torques."""
    told = {case: check_log(robot, log) for case, robot, log in lacking(1, seed=91)}
    assert len(told) > 20
    assert not [case for case, defects in told.items() if any(d.severity == "gross" for d in defects)]
    confused = {"sign", "order", "zero", "gravity", "unit", "ratio", "sum", "delay"}
    assert not [case for case, defects in told.items() if confused & {d.kind for d in defects}]
