"""Diagnoses of the two-joint robot, whose hidden law is known here."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from two_link_logs import TWO_LINK, hidden, in_process, loaded, made_log, two_link

from flexmodels.robot import Robot
from pyident.cli.main import main
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.nonlinear_values import proper
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.imitators.constancy import changes_with
from pyident.diagnosis.imitators.imitation import stands_in_for
from pyident.diagnosis.next_steps import with_experiments
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.searched import searched
from pyident.diagnosis.unexplained.residual_terms import RowSearch
from pyident.logs.log import Log, write_log
from pyident.rules.rules import RULES


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("diagnose")


def logs_of(robot: Robot, folder, count: int = 3) -> list[Log]:
    with loaded(robot, folder) as fmu:
        return [made_log(fmu, robot, seed) for seed in range(count)]


def with_law(effect: str, joint: int, **values: float) -> Robot:
    named = {f"joint{joint}.{effect}.{name}": value for name, value in values.items()}
    return two_link().with_effect(joint, effect).with_parameters(named)


def diagnosed(logs: list[Log]) -> tuple[Search, Diagnosis]:
    search = searched(two_link(), logs[:2], in_process)
    return search, concluded(search, in_process, logs[2:])


@pytest.fixture(scope="module")
def asymmetric_logs(folder):
    return logs_of(hidden(), folder)


@pytest.fixture(scope="module")
def asymmetric(asymmetric_logs):
    return diagnosed(asymmetric_logs)


def test_the_hidden_law_is_named(asymmetric):
    _, found = asymmetric
    assert found.verdict == "missing_effect"
    (finding,) = found.findings
    (best,) = finding.tie
    assert (best.effect, best.joint) == ("asymmetric_coulomb", "joint2")
    assert best.values["coulomb"] == pytest.approx(2.5, rel=0.05)
    assert best.values["viscous"] == pytest.approx(4.0, rel=0.05)
    assert finding.heldout_gain_percent is not None
    assert finding.heldout_gain_percent > 50
    assert found.localised == ("joint2", "motor")
    assert found.remaining < 2 < found.excess
    assert ("asymmetric_coulomb", "joint2") not in {(x.effect, x.joint) for x in found.limits if x.reason}


def test_nothing_hidden_is_nothing_found(folder):
    _, found = diagnosed(logs_of(two_link(), folder))
    assert found.verdict == "nothing_detectable"
    assert not found.findings
    smallest = {(x.effect, x.joint): x.smallest for x in found.limits if not x.reason}
    assert 0 < smallest["asymmetric_coulomb", "joint2"]["coulomb"] < 2.5  # what was found above


def test_a_true_law_keeps_its_coefficients(asymmetric):
    search, _ = asymmetric
    candidate = Candidate("asymmetric_coulomb", 2)
    search = search.resting_on([candidate])
    assert changes_with(search, candidate) == ""


@pytest.mark.slow
def test_an_imitator_does_not(folder):
    """A torque that grows with the square of the speed is no ripple of constant size."""
    logs = [_with_torque(log) for log in logs_of(two_link(), folder)]
    search = searched(two_link(), logs[:2], in_process)
    candidate = Candidate("torque_ripple", 1, (("order", 9.0),))
    search = search.resting_on([candidate])
    assert changes_with(search, candidate) == "speed"
    found = concluded(search, in_process, logs[2:])
    assert "torque_ripple" not in {n.effect for f in found.findings for n in f.tie}


@pytest.fixture(scope="module")
def foreign(folder):
    """Friction of joint 1 that grows with the bending of joint 2, which no law of the catalogue does."""
    made = []
    for log in logs_of(two_link(), folder):
        speed = np.gradient(log.frame["joint1.e"].to_numpy(), log.frame["time"].to_numpy())
        bending = np.abs(log.frame["joint2.eps[2]"].to_numpy())
        more = 4 * np.sign(speed) * bending / bending.mean()
        made.append(replace(log, frame=log.frame.assign(**{"joint1.tau": log.frame["joint1.tau"] + more})))
    return made


@pytest.mark.slow
def test_a_law_that_leaves_a_foreign_signal_stands_in_for_it(foreign, folder):
    search = searched(two_link(), foreign[:2], in_process)
    candidate = Candidate("load_dependent_friction", 1)
    search = search.resting_on([candidate])
    assert stands_in_for(search, candidate) == "friction with deformation 2 of joint 2"
    found = concluded(search, in_process, foreign[2:])
    assert found.verdict == "unexplained"


@pytest.mark.slow
def test_a_true_law_beside_an_unknown_force_stands_in_for_nothing(folder):
    logs = []
    for log in logs_of(hidden(), folder):
        bending = log.frame["joint1.eps[2]"].to_numpy()
        tau = log.frame["joint2.tau"] + 20 * np.tanh(2 * (bending - bending.mean()) / bending.std())
        logs.append(replace(log, frame=log.frame.assign(**{"joint2.tau": tau})))
    search = searched(two_link(), logs[:2], in_process)
    candidate = Candidate("asymmetric_coulomb", 2)
    search = search.resting_on([candidate])
    row = search.robot.coordinates.index("joint2.e")
    left = search.remaining_on([row])
    unknown = RowSearch(search.examination, search.base, row, left).strongest()
    assert unknown is not None
    assert unknown[0].on == "joint1.eps2"
    assert left > RULES.search.foreign_left * search.excess_in(Region((row,)))  # else nothing would be asked
    assert unknown[0].gain > 0.5 * left
    assert stands_in_for(search, candidate) == ""


def _with_torque(log: Log) -> Log:
    e = log.frame["joint1.e"].to_numpy()
    speed = np.gradient(e, log.frame["time"].to_numpy())
    return replace(
        log, frame=log.frame.assign(**{"joint1.tau": log.frame["joint1.tau"] + 3 * np.sin(9 * e) * speed**2})
    )


@pytest.mark.slow
def test_a_gap_must_take_the_stiffness_to_be_backlash(folder):
    robot = two_link()
    stiffness = robot.parameters["joint2.k[1]"]
    gap = Candidate("backlash", 2, (("gap", 2e-4),))
    assert proper(robot, gap, [0.9 * stiffness], robot.linear_parameters, 0.004)
    assert not proper(robot, gap, [0.3 * stiffness], robot.linear_parameters, 0.004)
    logs = logs_of(with_law("backlash", 2, stiffness=stiffness, gap=2e-4), folder, 2)
    best = searched(robot, logs, in_process).step().best.candidate
    assert (best.effect, best.joint) == ("backlash", 2)
    assert dict(best.values)["gap"] == pytest.approx(2e-4, rel=0.4)


def test_rivals_get_an_experiment(asymmetric, folder):
    search, found = asymmetric
    rival = next(n for n in found.ranking if n.effect == "nonlinear_viscous" and n.joint == "joint2")
    tied = replace(found.findings[0], tie=(*found.findings[0].tie, rival))
    (finding,) = with_experiments(
        search, replace(found, findings=(tied,)), in_process, lambda _: None
    ).findings
    assert finding.experiment.startswith("run ")
    assert "standard deviations" in finding.experiment


def test_the_command(monkeypatch, asymmetric, asymmetric_logs, tmp_path):
    """It hands the files' logs to the diagnosis, the last held out, and tells what that found."""
    paths = []
    for log in asymmetric_logs:
        paths.append(str(tmp_path / f"{log.source.replace(' ', '')}.parquet"))
        write_log(log, paths[-1])

    def known(robot, logs, open_pool, heldout, *_):
        assert robot == two_link()
        for read, log in zip([*logs, *heldout], asymmetric_logs, strict=True):
            pd.testing.assert_frame_equal(read.frame[list(log.frame)], log.frame)
        assert len(heldout) == 1
        return asymmetric[1]

    monkeypatch.setattr("pyident.verbs.judge.diagnosed", known)
    page, answer = tmp_path / "page.html", tmp_path / "answer.json"
    ran = CliRunner().invoke(
        main, ["diagnose", str(TWO_LINK), *paths, "-o", str(page), "--json", str(answer)]
    )
    assert ran.exit_code == 1, ran.output
    assert "Missing: asymmetric_coulomb at joint2" in ran.output
    said = json.loads(answer.read_text())
    assert said["verdict"] == "missing_effect"
    assert said["findings"][0]["tie"] == [{"effect": "asymmetric_coulomb", "joint": "joint2"}]
    assert "asymmetric_coulomb" in page.read_text()
