"""How far two explanations are apart along a cosine, against integrals over its period."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from test_criterion import DURATION, PERIOD, SIGMA, cosine, level, smooth_joint

from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import RobotError
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.result import Named
from pyident.excitation.criterion import along
from pyident.excitation.rehearsals.rehearsal import rehearsal
from pyident.excitation.separation.rivals import Rivals, Suspect, having, suspect, taken_out
from pyident.logs.log import Log
from pyident.regression.candidate_columns import effect_columns

QUADRATIC, HALF = 0.8, 0.3  # N m at 1 rad/s, N m s/rad
SPEED = 0.4 * np.pi  # largest [rad/s]
SAMPLES = round(DURATION / PERIOD)
ODD, EVEN = Suspect("nonlinear_viscous", 1), Suspect("asymmetric_coulomb", 1)
LEFT_OF_SQUARE = 3 / 8 - (8 / (3 * np.pi)) ** 2 / 2  # mean square of sin|sin| that no multiple of sin takes


def with_odd():
    return (
        smooth_joint()
        .with_effect(1, ODD.effect)
        .with_parameters({"joint1.nonlinear_viscous.coefficient": QUADRATIC})
    )


def with_even():
    return (
        smooth_joint()
        .with_effect(1, EVEN.effect)
        .with_parameters({"joint1.asymmetric_coulomb.viscous": HALF})
    )


def driven() -> Log:
    """The same cosine as a recording, under the torque of an inertia of 1.1 kg m2 and of the friction."""
    motion = cosine()
    time = np.arange(4 * SAMPLES) * PERIOD / 4
    e, de = (np.interp(time, motion.time, x[:, 0]) for x in (motion.q, motion.dq))
    tau = -1.1 * np.pi**2 * e + 2.0 * de
    return Log.from_frame(pd.DataFrame({"time": time, "joint1.e": e, "joint1.tau": tau}))


def score(rivals: Rivals) -> float:
    return rivals.score([[{}], [{}]])(along(rivals.base, level(PERIOD), cosine()))


def test_a_law_beside_none_is_as_far_as_the_robot_leaves_of_it():
    rivals = Rivals(smooth_joint(), (ODD, None), (with_odd(), smooth_joint()))
    expected = QUADRATIC * SPEED**2 * np.sqrt(SAMPLES * LEFT_OF_SQUARE) / SIGMA
    assert score(rivals) == pytest.approx(expected, rel=0.01)


def test_of_two_laws_the_closer_way_round_counts():
    """One is odd in the speed, the other even: neither takes anything of the other."""
    even = HALF * SPEED * np.sqrt(SAMPLES / 2) / SIGMA
    odd = QUADRATIC * SPEED**2 * np.sqrt(SAMPLES * LEFT_OF_SQUARE) / SIGMA
    assert odd < even
    both = Rivals(smooth_joint(), (ODD, EVEN), (with_odd(), with_even()))
    turned = Rivals(smooth_joint(), (EVEN, ODD), (with_even(), with_odd()))
    assert score(both) == score(turned) == pytest.approx(odd, rel=0.01)


def test_the_grid_of_a_suspect_holds_its_own_values():
    log = driven()
    slow = having(smooth_joint(), Suspect("stribeck", 1), log).with_parameters(
        {"joint1.stribeck.velocity": 0.123}
    )
    rivals = Rivals(smooth_joint(), (Suspect("stribeck", 1), None), (slow, smooth_joint()))
    first, second = rivals.grids(log)
    assert first[-1] == {"velocity": 0.123}
    assert len(first) > 2
    assert second == [{}]


def test_an_effect_of_unknown_size_is_small_beside_the_torque():
    log = driven()
    extended = having(smooth_joint(), EVEN, log)
    values = extended.joints[0].values[EVEN.effect]
    speed = np.gradient(log.frame["joint1.e"], log.period)
    force = values["coulomb"] + values["viscous"] * np.abs(speed)
    share = np.sqrt(np.mean(force**2) / np.mean(log.frame["joint1.tau"] ** 2))
    assert 0.02 < share < 0.06
    sized = having(smooth_joint(), replace(ODD, size=2.5), log)
    assert sized.parameters["joint1.nonlinear_viscous.coefficient"] == 2.5


@pytest.mark.parametrize("size", [None, 1e-4])
def test_backlash_is_sized_by_its_gap(size):
    """Within which nearly the whole stiffness is missing: less would be no backlash."""
    robot = load_robot("four_link")
    with rehearsal(robot) as own:
        log = own.log(identification(robot, duration=2.0))
    extended = having(robot, Suspect("backlash", 2, size), log)
    found = extended.joints[1].values["backlash"]
    twist = float(np.sqrt(np.mean(log.frame["joint2.eps[1]"] ** 2)))
    assert found["gap"] == pytest.approx(size or 0.1 * twist, rel=0.05)
    assert found["stiffness"] == pytest.approx(0.9 * robot.parameters["joint2.k[1]"])
    law = extended.joints[1].law("backlash")
    assert law.size.name == "gap"


def test_all_that_a_diagnosis_found_of_a_law_is_taken():
    """Two parameters of one size each would cancel in a counterbalance's torque."""
    log, found = driven(), {"stiffness": 9.5, "preload": 8.25, "ratio": 0.375, "phase": 1.5}
    named = Named("gravity_spring", "joint1", found, {}, {}, 100.0)
    extended = having(smooth_joint(), suspect(named.suspect), log)
    assert extended.joints[0].values["gravity_spring"] == found
    unknown = having(smooth_joint(), suspect("gravity_spring@1=ratio=0.4"), log)
    columns = effect_columns(unknown, 1, "gravity_spring", condition(log, unknown).motion)
    values = unknown.joints[0].values["gravity_spring"]
    torque = sum(values[name] * rows[0] for name, rows in columns.items())
    share = np.sqrt(np.mean(torque**2) / np.mean(log.frame["joint1.tau"] ** 2))
    assert share == pytest.approx(0.05, rel=0.05)
    assert values["ratio"] == 0.4
    with pytest.raises(RobotError, match="no parameter 'size'; they are stiffness, preload, ratio, phase"):
        having(smooth_joint(), suspect("gravity_spring@1=size=3"), log)


def test_a_law_that_is_there_already_is_refused():
    with pytest.raises(RobotError, match="has nonlinear_viscous@1 already"):
        having(with_odd(), ODD, driven())


def test_a_law_of_the_model_is_taken_out_and_its_values_are_supposed():
    plain, who = taken_out(with_odd(), ODD)
    assert plain == smooth_joint()
    assert having(plain, who, driven()) == with_odd()
    _, given = taken_out(with_odd(), suspect("nonlinear_viscous@1=3"))
    law = having(plain, given, driven()).joints[0].values["nonlinear_viscous"]
    assert law == {**with_odd().joints[0].values["nonlinear_viscous"], "coefficient": 3.0}
    without_size = smooth_joint().with_effect(1, ODD.effect)
    assert taken_out(without_size, ODD) == (smooth_joint(), ODD)  # as large as anything unknown


@pytest.mark.parametrize("who", [ODD, Suspect("coulomb", 1), Suspect("stribeck", 9)])
def test_what_is_no_law_of_the_model_or_one_of_every_robot_stays(who):
    assert taken_out(smooth_joint(), who) == (smooth_joint(), who)
