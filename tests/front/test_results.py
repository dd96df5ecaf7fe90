"""What outcomes say of themselves."""

import json
from dataclasses import replace

import numpy as np
import pytest
from two_link_logs import two_link

import pyident as pi
from flexmodels.inputs import Experiment
from pyident.verbs.text import Text


@pytest.fixture(scope="module")
def log(two_link_robot):
    """Ten seconds of both joints swinging, the second faster."""
    time = np.arange(2001) / 200
    reference = np.column_stack([0.5 * (1 - np.cos(2 * time)), 0.4 * (1 - np.cos(5 * time))])
    torque = np.column_stack([3 * np.sin(23 * time), 2 * np.sin(31 * time)])
    return pi.simulate(two_link_robot, Experiment(time, reference, torque))


@pytest.fixture(scope="module")
def two_link_robot():
    return two_link()


@pytest.fixture(scope="module")
def fit(two_link_robot, log):
    return pi.identify(two_link_robot, log)


def test_the_parameters_come_back(two_link_robot, fit):
    found, true = fit.to_frame(), two_link_robot.parameters
    alone = found[found["identifiable"] == "alone"]
    assert len(alone) > 5
    assert alone.loc["joint1.coulomb", "value"] == pytest.approx(true["joint1.coulomb"], rel=0.02)
    assert alone.loc["joint1.coulomb", "unit"] == "N.m"


def test_a_frame_and_a_list_of_paths_give_the_same(two_link_robot, log, fit, tmp_path):
    pi.write_log(log, tmp_path / "log.parquet")
    for given in (log.frame, [tmp_path / "log.parquet"]):
        again = pi.identify(two_link_robot, given)
        np.testing.assert_allclose(again.identified.solution.p, fit.identified.solution.p, rtol=1e-9)


def test_both_errors_are_told_and_that_of_the_model_follows_from_its_file(fit, tmp_path):
    """The written parameters, put into the regression's own equations, leave what is printed."""
    said = fit.to_dict()
    solved, written = said["relative_error_percent"]["all"], said["relative_error_of_model_percent"]["all"]
    assert written == pytest.approx(solved, rel=0.05)  # a log with little noise
    saved = pi.load_robot(fit.save(tmp_path / "identified.toml"))
    reduced = fit.identified.reduced
    p = np.array([saved.parameters[name] for name in reduced.columns])
    rows = reduced.triangles[: len(saved.joints)]
    left = rows[:, :, -1] - rows[:, :, :-1] @ p
    assert written == pytest.approx(100 * np.sqrt((left**2).sum() / (rows[:, :, -1] ** 2).sum()), rel=1e-6)
    assert "model that is written" in fit.summary()
    assert "these errors hold the sensors' noise" in " ".join(fit.summary().split())


def test_a_written_model_that_is_no_robot_is_told(fit):
    """Bodies of tons that cancel each other, as logs say that move one joint at a time."""
    robot = fit.identified.robot
    heavy = {name: 1e4 * v for name, v in robot.parameters.items() if name.startswith("link")}
    found = replace(fit.identified, robot=robot.with_parameters(heavy))
    told = replace(fit, identified=found).summary()
    assert "do not use the model that is written" in " ".join(told.split())
    assert "do not use" not in fit.summary()


def test_an_outcome_is_short_in_a_list_and_whole_in_a_notebook(fit):
    assert len(repr(fit)) < 160
    assert "\n" not in repr(fit)
    assert "<table" in fit._repr_html_()
    assert json.loads(fit.to_json()) == fit.to_dict()
    assert repr(fit.summary()) == str(fit.summary())
    with pytest.raises(AttributeError):
        fit.notes = ()


def test_a_hinge_that_no_log_tells_of_is_locked_and_said_so(two_link_robot, log):
    lost = [name for name in log.names if ".eps[" in name]
    assert lost
    fit = pi.identify(two_link_robot, log.frame.drop(columns=lost))
    assert any("joint 2: no link-side encoder (joint2.eps[1])" in note for note in fit.notes)
    assert not fit.robot.joints[1].flexible
    assert any("the [controller] is not used" in note for note in fit.notes)
    assert fit.robot.controller == two_link_robot.controller


def test_text_is_escaped_in_a_notebook():
    assert "<script>" not in Text("<script>")._repr_html_()


def test_the_figure_shows_each_base_parameters_interval(fit):
    (axes,) = fit.plot().axes
    drawn = {
        t.get_text(): bar.get_width() for t, bar in zip(axes.get_yticklabels(), axes.patches, strict=True)
    }
    base = fit.base_frame()
    for name, width in drawn.items():
        assert width == pytest.approx(1.96 * base.loc[name, "std"] / abs(base.loc[name, "value"]))
    assert len(drawn) > 5
