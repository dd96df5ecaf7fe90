"""Our own FMU known by its variables alone: hidden parameters, nothing hidden, the commands."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from one_joint import one_joint

import pyident as pi
from flexmodels.experiment import Experiment, identification
from flexmodels.inputs import SimulationError
from flexmodels.robot import RobotError
from pyident.cli.main import main
from pyident.logs.log import LogError


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """FMI version -> FMU of an arm with friction and a controller."""
    folder = tmp_path_factory.mktemp("arm")
    return {v: pi.export_fmu(one_joint(), folder / f"arm{v}.fmu", fmi=v) for v in (2, 3)}


def logged(robot, parameters=None, duration=4.0):
    plan = identification(one_joint(), duration=duration)
    return pi.simulate(robot, plan, parameters=parameters)


@pytest.mark.parametrize("fmi", [2, 3])
def test_hidden_parameters_are_told(arm, fmi):
    hidden = {"joint1.coulomb": 1.6, "joint1.viscous": 1.3, "joint1.J_m": 0.7}
    fit = pi.identify_fmu(arm[fmi], logged(one_joint(), hidden, 1.0), list(hidden))
    assert fit.values == pytest.approx(hidden, rel=1e-3)


def test_what_the_logs_do_not_tell_is_said(arm):
    """Motor and link turn together: only the sum of their inertias shows."""
    fit = pi.identify_fmu(arm[2], logged(one_joint(), duration=1.0), ["joint1.J_m", "link1.J[3,3]"])
    frame = fit.to_frame()
    assert list(frame["identifiable"]) == ["no", "no"]
    assert np.isnan(frame["std"].to_numpy(float)).all()


def wandering(duration=8.0):
    """A motion of several turns that does not repeat itself; in one that does, all signals look alike."""
    time, rng = 0.004 * np.arange(round(duration / 0.004) + 1), np.random.default_rng(5)
    waves = 2 * np.pi * np.outer(time, rng.uniform(0.1, 0.9, 7))
    phase = rng.uniform(0, 6.28, 7)
    start = np.clip(time, 0, 1) ** 2 * (3 - 2 * np.clip(time, 0, 1))
    reference = 0.45 * start[:, None] * (np.sin(waves + phase) - np.sin(phase)).sum(axis=1, keepdims=True)
    return Experiment(time=time, reference=reference, feedforward=np.zeros_like(reference))


@pytest.mark.parametrize(
    ("law", "kind", "at"),
    [
        ({"torque_ripple": {"cosine": 2.0, "sine": 1.0, "order": 12.0}}, "order", 12),
        ({"gravity_spring": {"stiffness": 4.0, "preload": 0.0, "ratio": 0.5, "phase": 0.3}}, "signal", 0),
    ],
    ids=["torque_ripple", "gravity_spring"],
)
def test_a_hidden_law_shows_in_the_torque(arm, law, kind, at):
    """By its order, or by the angle on which it depends."""
    robot = one_joint()
    joint = robot.joints[0]
    hidden = replace(robot, joints=(replace(joint, values={**joint.values, **law}),))
    frame = pi.simulate(hidden, wandering()).frame
    log = frame.filter(["time", "joint1.r", "joint1.tau_ff", "joint1.tau"])
    shown = pi.diagnose_fmu(arm[2], log)
    first = shown.outputs[0].findings[0]
    assert (shown.verdict, first.kind, first.at) == ("depends", kind, at)
    assert "joint1.e" in first.of


def test_nothing_hidden_is_nothing(arm):
    log = logged(one_joint())
    assert pi.diagnose_fmu(arm[2], log).verdict == "nothing_detectable"
    errors = pi.compare_fmu(arm[2], log).errors[log.source]
    assert max(e["rmse"] for e in errors.values()) < 1e-9


def test_wrong_names_are_refused(arm, tmp_path):
    log = logged(one_joint(), duration=0.4)
    with pytest.raises(RobotError, match="no variable mass"):
        pi.identify_fmu(arm[2], log, ["mass"])
    with pytest.raises(RobotError, match="computed by the FMU"):
        pi.identify_fmu(arm[2], log, ["joint1.friction"])
    with pytest.raises(RobotError, match="identify_fmu"):
        pi.identify(arm[2], log)
    with pytest.raises(SimulationError, match="there is no FMU"):
        pi.compare_fmu(tmp_path / "none.fmu", log)
    with pytest.raises(pi.LogError, match="no column is an output"):
        pi.compare_fmu(arm[2], log.frame.filter(["time", "joint1.r"]))


def test_questions_that_no_fmu_answers_are_refused(arm):
    log = logged(one_joint(), duration=0.4)
    with pytest.raises(LogError, match="there is no log; give one or more"):
        pi.compare_fmu(arm[2], [])
    without = pi.Log(log.frame.drop(columns="joint1.tau"), "short")
    with pytest.raises(LogError, match=r"short: its outputs are .*give logs with the same columns"):
        pi.compare_fmu(arm[2], [log, without])
    with pytest.raises(RobotError, match="the lower bound 2 is not below the upper one 1"):
        pi.identify_fmu(arm[2], log, {"joint1.coulomb": (2.0, 1.0)})
    with pytest.raises(RobotError, match=r"joint1\.r is not a continuous parameter"):
        pi.identify_fmu(arm[2], log, ["joint1.r"])


def test_a_diagnosis_fits_first_what_it_may(arm):
    """Once the friction is fitted nothing is left but arithmetic; the progress reaches its end."""
    told: list[float] = []
    log = logged(one_joint(), {"joint1.coulomb": 1.6}, 1.0)
    found = pi.diagnose_fmu(arm[2], log, parameters=["joint1.coulomb"], progress=told.append)
    assert found.to_dict()["fitted"] == pytest.approx({"joint1.coulomb": 1.6}, rel=1e-3)
    assert max(output.rms for output in found.outputs) < 0.01
    assert told == sorted(told)
    assert told[-1] == 1.0


def test_the_commands_take_an_fmu(arm, tmp_path):
    path, out = tmp_path / "log.csv", tmp_path / "fit.json"
    pi.write_log(logged(one_joint(), {"joint1.viscous": 1.3}, 1.0), path)
    run = CliRunner().invoke
    words = ["identify", str(arm[2]), str(path), "--parameters", "joint1.viscous=0:9", "joint1.coulomb"]
    told = run(main, [*words, "--json", str(out)])
    assert told.exit_code == 0, told.output
    assert json.loads(out.read_text())["parameters"]["joint1.viscous"]["value"] == pytest.approx(
        1.3, rel=1e-2
    )
    told = run(main, ["compare", str(arm[2]), str(path), "--set", "joint1.viscous=1.3"])
    assert told.exit_code == 0
    assert "joint1.e" in told.output
    assert run(main, ["identify", "four_link", str(path), "--parameters", "a"]).exit_code == 2
    assert run(main, ["identify", str(arm[2]), str(path)]).exit_code == 2
