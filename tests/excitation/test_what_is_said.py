"""What a planned motion says of itself, with and without a promise."""

from dataclasses import replace

import numpy as np
import pytest
from planned_joint import FEW, limited

import pyident as pi
from flexmodels.experiment import Experiment
from pyident.excitation.design import Offer, nearer
from pyident.excitation.design import rehearsed as rehearsals_of
from pyident.excitation.rehearsals.jury import Jury
from pyident.excitation.search import Best
from pyident.excitation.task import task_of
from pyident.refinement.identifications import DEFAULT, IDENTIFICATIONS
from pyident.verbs.planned import Promise

STRIBECK = {"joint1.stribeck.level": 0.5, "joint1.stribeck.velocity": 0.05}


@pytest.fixture(scope="module")
def planned() -> pi.Planned:
    return pi.excite(limited(), **FEW)


@pytest.fixture(scope="module")
def promised(planned) -> pi.Planned:
    """It is to tell a law from none."""
    rival = limited().with_effect(1, "stribeck").with_parameters(STRIBECK)
    return replace(planned, promise=Promise(("stribeck@1", "no further law"), 12.34, (rival, limited())))


def test_without_a_question_it_says_what_an_identification_will_find(planned):
    assert planned.headline().startswith(f"{planned.robot.name}, a motion of ")
    rank = planned.prediction.rank
    assert f"rank {rank} of {len(planned.prediction.std)} parameters" in planned.headline()
    summary = str(planned.summary())
    assert "joint1.viscous" in summary
    assert f"rehearsed by {planned.design.rehearsed} robots with every parameter 25 % off" in summary
    assert "separation" not in planned.to_dict()


def test_a_zero_of_the_model_is_no_prediction(planned):
    """Friction that the robot file has at 0, as one that was imported."""

    def said(viscous: float) -> str:
        values = {**planned.prediction.values, "joint1.viscous": viscous}
        other = replace(planned, prediction=replace(planned.prediction, values=values))
        return " ".join(str(other.summary()).split())

    words = "a 0 in the model may be a value that nobody has identified yet"
    assert words in said(0.0)
    assert words not in said(2.0)


@pytest.mark.parametrize(
    ("ended", "words"),
    [(pi.LogError("too short"), "`identify` would give no values of a log of this motion: too short"),
     (KeyboardInterrupt(), "interrupted before a log of this motion was identified")],
)  # fmt: skip
def test_a_motion_is_kept_where_its_log_is_not_identified(planned, monkeypatch, ended, words):
    def refusing(*_):
        raise ended

    monkeypatch.setitem(IDENTIFICATIONS, DEFAULT, refusing)
    checked = pi.check_plan(planned.plan, limited(), floor=None, others=1)
    assert words in checked.notes
    said = checked.to_dict()["parameters"]["joint1.viscous"]
    assert said["std"] is None
    assert said["std_regression"] > 0
    assert "± 95 % by a plain regression" in str(checked.summary())


def test_its_values_come_with_predicted_deviations_and_null_where_there_is_none(planned):
    said = planned.to_dict()
    row = said["parameters"]["joint1.viscous"]
    assert row["std"] == pytest.approx(planned.to_frame().loc["joint1.viscous", "std"])
    unknown = [name for name, std in planned.prediction.std.items() if not np.isfinite(std)]
    assert unknown  # one joint tells of its link only in sums
    assert all(said["parameters"][name]["std"] is None for name in unknown)
    rms = float(np.sqrt(np.mean(planned.plan.feedforward**2)))
    assert said["multisine"] == {"joint1": pytest.approx(rms)}
    assert said["duration_s"] == planned.plan.time[-1]


def test_a_promise_is_what_it_says_first_with_what_it_supposes(promised):
    words = "stribeck@1 and no further law will differ by 12.3 standard deviations, which settles it"
    assert promised.headline().endswith(words)
    summary = " ".join(str(promised.summary()).split())
    assert words in summary
    assert "supposed of stribeck@1: level = 0.5, velocity = 0.05" in summary
    supposed = promised.to_dict()["separation"]["supposed"]
    assert list(supposed) == ["stribeck@1"]  # the rival without a law supposes nothing
    assert supposed["stribeck@1"]["velocity"] == 0.05


@pytest.mark.parametrize(("sigmas", "ending"), [(5.0, "which settles it"), (4.9, "which does not settle it")])
def test_five_deviations_settle_a_question(promised, sigmas, ending):
    assert replace(promised.promise, sigmas=sigmas).sentence.endswith(ending)


def test_a_law_of_the_model_is_asked_about_and_a_note_says_how():
    robot = limited().with_effect(1, "stribeck").with_parameters(STRIBECK)
    found = pi.excite(robot, reveal="stribeck@1", duration=3.0, evaluations=3, floor=None)
    assert found.promise is not None
    assert found.promise.supposed["stribeck@1"] == pytest.approx({"level": 0.5, "velocity": 0.05})
    assert "stribeck@1 is in the model: it was taken out to be asked about" in found.notes[0]
    assert "joint1.stribeck.level" not in found.prediction.values


@pytest.mark.parametrize(("holds", "rehearsed"), [(0.3, 0.25), (0.15, 0.125), (0.07, 0.0625), (0.05, None)])
def test_where_no_robot_so_far_off_may_move_others_rehearse_it(monkeypatch, holds, rehearsed):
    """A loop that holds parameters off by `holds` at most; nothing is run."""
    monkeypatch.setattr(Jury, "__init__", lambda self, *given: setattr(self, "spread", given[-1]))
    monkeypatch.setattr(Jury, "others", [], raising=False)
    monkeypatch.setattr(Jury, "broken", lambda self, plan: "the loop" if self.spread > holds else "")
    task = task_of(limited(), 3.0, None, None, None, None, None, 0.25)
    time = np.arange(751) / 250
    plan = Experiment(time, 0.3 * np.sin(np.pi * time / 3)[:, None] ** 4, np.zeros((751, 1)))
    offer = Offer(plan, Best(np.zeros(1), 0.0, 1, False))
    if rehearsed is None:
        with pytest.raises(pi.RobotError, match=r"keeps a limit of the loop with parameters 6.25 % off"):
            rehearsals_of(task, [offer], (), lambda share: None)
        return
    design = rehearsals_of(task, [offer], (), lambda share: None)
    assert design.spread == rehearsed
    said = nearer(task, design)
    assert bool(said) == (rehearsed < 0.25)
    assert all(f"rehearsed with {100 * rehearsed:g} % (plan check --spread {rehearsed:g})" in s for s in said)
