"""Two explanations brought apart: the promise of a motion is kept by noisy logs, and refits are free."""

import numpy as np
import pytest
from planned_joint import limited

from flexmodels.robot import RobotError
from pyident.excitation.capsules import geometry_of
from pyident.excitation.design import Drawing, Task, designed, measure, starts
from pyident.excitation.limits import limits_of
from pyident.excitation.rehearsal import rehearsal
from pyident.excitation.rivals import Rivals, Suspect, distance, fall, having, suspect
from pyident.excitation.search import Budget

SIGMA = 1e-5


def test_suspects_are_read_and_wrong_ones_refused():
    assert suspect("stribeck@2") == Suspect("stribeck", 2)
    assert suspect("backlash@3=1e-4") == Suspect("backlash", 3, 1e-4)
    with pytest.raises(RobotError, match="EFFECT@JOINT"):
        suspect("backlash")


def test_noisy_logs_differ_by_what_was_promised():
    """The wrong one of two friction laws leaves promise² more than the right one."""
    robot = limited()
    task = Task(robot, limits_of(robot), geometry_of(robot, floor=None), {"joint1.e": SIGMA}, 3.0, 250.0)
    drawing = Drawing(task)
    with rehearsal(robot) as own:
        level = measure(task, drawing, own)
        drawn = (drawing.reference(x, 0.004) for x in starts(drawing.family, 20))
        first = next(reference for reference in drawn if reference is not None)
        log = own.log(drawing.plan(first))
    pair = (Suspect("stribeck", 1), Suspect("nonlinear_viscous", 1))
    one, other = (having(robot, who, log) for who in pair)
    rivals = Rivals(robot, pair, (one, other))
    with rehearsal(robot) as own, rehearsal(one) as true, rehearsal(other) as wrong:
        score = rivals.score(rivals.grids(log))
        found = designed(task, drawing, score, level, own, Budget(40), rivals=(true, wrong))
        clean = true.log(found.plan)
        promise = distance(rivals, 0, clean, level)
        rng, falls = np.random.default_rng(5), []
        for _ in range(10):
            noise = SIGMA * rng.standard_normal(len(clean))
            frame = clean.frame.assign(**{"joint1.e": clean.frame["joint1.e"] + noise})
            falls.append(fall(rivals, 0, type(clean)(frame), level))
    assert promise > 5
    assert np.sqrt(np.mean(falls)) == pytest.approx(promise, rel=0.2)
