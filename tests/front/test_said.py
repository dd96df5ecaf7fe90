"""What the outcomes of compare, diagnose and add say, from outcomes written by hand."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from one_joint import one_joint
from outcomes import ADDED, DIAGNOSIS, compared

from flexmodels.robot import RobotError
from pyident.extension.extended_robot import Correction
from pyident.greybox.residual import Finding as Dependence
from pyident.greybox.residual import Shown
from pyident.refinement.closed_loop import ClosedLoopFit
from pyident.verbs.fitted import ServoFit
from pyident.verbs.fmu.results import FmuDiagnosed
from pyident.verbs.judged import Added, Diagnosed, side_by_side


def test_a_finding_is_said_with_what_the_logs_leave_open():
    text = str(Diagnosed(DIAGNOSIS, ()).summary())
    squeezed = " ".join(text.split())
    assert "level = 8.123 N.m, velocity = 0.0517 rad/s" in squeezed
    assert "share not determined by itself" in squeezed
    assert "97 %" in squeezed
    assert "to separate: slow reversals" in squeezed
    assert "It repeats with time at 7.5 Hz." in squeezed
    assert "cannot show law0 at joint1, law1 at joint1, law2 at joint1, law3 at joint1 and 2 more" in squeezed


def test_no_share_of_an_excess_is_said_to_be_more_than_all():
    first, *others = DIAGNOSIS.findings
    more = replace(first, share_percent=120.0, heldout_gain_percent=216.0)
    text = " ".join(str(Diagnosed(replace(DIAGNOSIS, findings=(more, *others)), ()).summary()).split())
    assert "100 % 100 %" in text
    assert "216" not in text


def test_a_share_of_held_out_data_is_said_with_what_chance_may_do_to_it():
    first, *others = DIAGNOSIS.findings
    weak = replace(first, heldout_gain_percent=58.2, heldout_std_percent=40.4)
    told = Diagnosed(replace(DIAGNOSIS, findings=(weak, *others)), ())
    assert "58 ± 40 %" in " ".join(str(told.summary()).split())
    assert told.to_frame()["heldout_std_percent"].iloc[0] == 40.4


def test_nothing_found_is_one_sentence():
    nothing = replace(DIAGNOSIS, findings=(), limits=DIAGNOSIS.limits[:1], depends_on=(), sentence="Nothing.")
    lines = str(Diagnosed(nothing, ()).summary()).splitlines()
    assert lines[0] == "Nothing."
    assert "more" not in lines[1]
    assert Diagnosed(nothing, ()).to_frame().empty


def test_a_picture_has_a_cell_for_every_band():
    figure = Diagnosed(DIAGNOSIS, ()).plot()
    (image,) = figure.axes[0].images
    np.testing.assert_array_equal(image.get_array(), [[12.5, 1.25]])
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["joint1.e"]


def test_a_waterfall_has_two_bars_a_step():
    axes = Added(ADDED, ()).plot().axes[0]
    assert [cast(Any, bar).get_width() for bar in axes.patches] == [4.0, 2.0]  # over the floor


def test_an_added_law_is_said_with_its_parameters_and_its_fall():
    added = Added(ADDED, ("a note",))
    text = " ".join(str(added.summary()).split())
    assert "torque of joint 1 held out 2 1 0.5 N.m" in text
    assert "joint1.stribeck.level" in text or "stribeck" in text
    assert "follows held-out data better" in text
    assert added.to_frame().loc["torque of joint 1", "after"] == 1.0
    assert added.to_dict()["mean_square_fall_percent"] == {"equations": 75.0, "simulation": 50.0}


def test_a_simulation_that_does_not_follow_is_not_said_to():
    added = Added(replace(ADDED, gains=(0.75, -0.01)), ())
    assert added.headline().endswith("its equations follow held-out data better, its simulation does not")


def test_a_corrected_description_is_said_with_the_line_of_the_file():
    corrected = replace(
        ADDED, robot=one_joint(), correction=Correction("r of joint 1", 0.006, "m", "r = 1", "r = 1.006")
    )
    assert "r of joint 1: r = 1 becomes r = 1.006" in str(Added(corrected, ()).summary())


def test_a_refused_law_writes_nothing(tmp_path):
    refused = Added(replace(ADDED, reason="the error rises"), ())
    with pytest.raises(RobotError, match=r"robot\.toml is not written: the error rises"):
        refused.save(tmp_path / "robot.toml")
    assert not list(tmp_path.iterdir())
    assert Added(ADDED, ()).save(tmp_path / "robot.toml").is_file()


def test_models_stand_side_by_side():
    text = " ".join(str(side_by_side(["old", "new"], [compared(2.0), compared(1.0)])).split())
    assert "old: it misses by 2" in text
    assert " 2 20 4 1 10 2 5" in text  # rmse, % of signal and over the floor of each; the floor in %
    frame = compared(2.0).to_frame()
    assert frame.loc[("a.csv", "equations", "joint1.e"), "over_floor"] == 4.0


SHOWN = Shown("y", "rad", 0.1, 0.5, ())


@pytest.mark.parametrize(
    ("output", "verdict", "sentence"),
    [
        (SHOWN, "nothing_detectable", "arm: what it leaves of its outputs is white noise"),
        (
            replace(SHOWN, white_p=1e-9),
            "unexplained",
            "the residual of y is no white noise, and follows no signal",
        ),
        (
            replace(SHOWN, findings=(Dependence("y", "delay", (), -0.004, 0.1, 80.0, 1e-9),)),
            "depends",
            "80 % of what is left of y: the log is 0.004 s earlier than the model",
        ),
        (
            replace(SHOWN, findings=(Dependence("y", "order", ("q",), 4.0, 0.1, 80.0, 1e-9),)),
            "depends",
            "80 % of what is left of y is periodic in q, 4 times per turn, rms 0.1 rad",
        ),
        (
            replace(SHOWN, findings=(Dependence("y", "signal", ("v", "w"), 0.0, 0.1, 80.0, 1e-9),)),
            "depends",
            "80 % of what is left of y depends on v or w, rms 0.1 rad",
        ),
    ],
)
def test_what_a_residual_shows_is_said(output, verdict, sentence):
    found = FmuDiagnosed("arm", (output,), None, ())
    assert found.verdict == verdict
    assert sentence in found.headline()
    assert sentence in " ".join(str(found.summary()).split())
    assert len(found.to_frame()) == len(output.findings)
    assert found.to_dict()["outputs"]["y"]["white_p_value"] == output.white_p


def test_the_error_of_a_servo_is_in_the_unit_of_its_joint():
    fit = ClosedLoopFit(one_joint(), {"joint1.coulomb": 1.0}, None, (0.002,))
    said = ServoFit(fit, ("a.csv",), ())
    assert "a.csv: mean absolute position error 0.002 rad\n" in str(said.summary())
    assert said.headline() == "one_joint: positions followed to 0.002 rad on the worst of 1 logs"
