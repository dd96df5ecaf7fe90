"""Logs without a feed-forward column: recovered from any start; controllers that are another."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from pyident.logs.log import Log, LogError, read_log
from pyident.simulation.feedforward import controller_torque, misfits
from pyident.simulation.fmu_runs import simulate_robot
from pyident.simulation.recorded import loop_of, recorded
from pyident.simulation.replay import replay_of
from pyident.simulation.replica import repeats, with_noise

FOREIGN = Path(os.environ.get("PYIDENT_DATA", "/nowhere")) / "foreign"
measured = pytest.mark.skipif(not FOREIGN.is_dir(), reason="PYIDENT_DATA holds no foreign logs")
FEEDFORWARD = [f"joint{k}.tau_ff" for k in range(1, 5)]


@pytest.fixture(scope="module")
def noisy(four_link) -> Log:
    """Four seconds whose encoders' noise goes through the loop."""
    plan, rng = identification(four_link, duration=4.0), np.random.default_rng(3)
    noise = {f"joint{k}.e": 2e-6 * rng.standard_normal(len(plan.time)) for k in range(1, 5)}
    return Log(with_noise(lambda made: simulate_robot(four_link, made), plan, noise), "noisy")


def bare(log: Log) -> Log:
    return replace(log, frame=log.frame.drop(columns=FEEDFORWARD))


def test_a_dropped_column_is_recovered_to_rounding(four_link, identification_log):
    plan = recorded(four_link, bare(identification_log)).plan
    given = identification_log.frame[FEEDFORWARD].to_numpy()
    np.testing.assert_allclose(plan.feedforward, given, atol=1e-6)


def test_one_missing_column_of_four_is_recovered(four_link, identification_log):
    log = replace(identification_log, frame=identification_log.frame.drop(columns="joint2.tau_ff"))
    given = identification_log.frame[FEEDFORWARD].to_numpy()
    plan = recorded(four_link, log).plan
    assert np.array_equal(plan.feedforward[:, [0, 2, 3]], given[:, [0, 2, 3]])
    np.testing.assert_allclose(plan.feedforward[:, 1], given[:, 1], atol=1e-6)


def test_encoder_noise_in_the_loop_does_not_spoil_what_is_recovered(four_link, noisy):
    """The torque answers the noise that the log holds, so it cancels; at the start it shifts the pose."""
    plan = recorded(four_link, bare(noisy)).plan
    np.testing.assert_allclose(plan.feedforward, noisy.frame[FEEDFORWARD], atol=5e-3)


def test_a_log_cut_in_the_middle_of_a_motion_is_followed_after_a_lead_in(four_link, identification_log):
    whole = identification_log.frame
    log = Log(bare(identification_log).frame.iloc[700:2200].reset_index(drop=True), "cut")
    inputs = recorded(four_link, log)
    assert inputs.lead == 250
    frame = inputs.cut(simulate_robot(four_link, inputs.plan))
    assert len(frame) == len(log)
    e = [f"joint{k}.e" for k in range(1, 5)]
    missed = frame[e].to_numpy() - whole[e].iloc[700:2200].to_numpy()
    assert np.abs(missed[:10]).max() < 2e-3
    assert np.abs(missed[500:]).max() < 2e-5  # what the unknown start left has died away


def test_another_controller_than_the_robot_files_is_noticed(four_link, identification_log, noisy):
    assert misfits(four_link, bare(noisy)) == []
    assert misfits(four_link, bare(identification_log)) == []
    gains = four_link.controller
    softer = replace(four_link, controller=replace(gains, Kd=tuple(0.5 * d for d in gains.Kd)))
    wrong = misfits(softer, bare(noisy))
    assert [m.joint for m in wrong] == [1, 2, 3, 4]
    assert wrong[0].percent == pytest.approx(82, abs=5)  # Kp + Kd/T + Ki T over the same with half of Kd
    with pytest.raises(LogError, match=r"does not fit joint 1: .* differently"):
        replay_of(softer, bare(noisy))
    simulated, (way,) = repeats(softer, [bare(noisy)])
    assert way.note is not None
    assert simulated.controller is not softer.controller
    assert np.array_equal(way.plan.reference, noisy.signals([f"joint{k}.e" for k in range(1, 5)]))


def test_samples_of_another_rate_are_not_taken_for_the_controllers(four_link, identification_log):
    log = Log(bare(identification_log).frame.iloc[::2].reset_index(drop=True), "half")
    assert "125 samples a second are not those of the controller (250)" in (loop_of(four_link, log) or "")


@measured
def test_the_excitation_of_another_simulators_log_is_recovered():
    """Its README gives the rms of the multisine that the log does not hold."""
    log = read_log(FOREIGN / "null_four_link" / "paper.parquet")
    robot = load_robot("four_link")
    plan = recorded(robot, log).plan
    rms = np.std(plan.feedforward, axis=0)
    np.testing.assert_allclose(rms, [60, 70, 30, 12], rtol=5e-3)
    assert _leakage(robot, plan.feedforward) < 1e-3


@measured
@pytest.mark.parametrize("case", ["null_four_link", "presliding_four_link", "null_scara"])
def test_foreign_logs_fit_their_controllers(case):
    own = FOREIGN / case / "scara.toml"
    robot = load_robot(str(own) if own.is_file() else "four_link")
    logs = [read_log(path) for path in sorted((FOREIGN / case).glob("*.parquet"))]
    assert [loop_of(robot, log) for log in logs] == [None] * 3


def _leakage(robot: Robot, feedforward: np.ndarray) -> float:
    """Share of power above 60 Hz, where that excitation has none."""
    power = np.abs(np.fft.rfft(feedforward * np.hanning(len(feedforward))[:, None], axis=0)) ** 2
    assert robot.controller is not None
    return float(power[np.fft.rfftfreq(len(feedforward), robot.controller.period) > 60].sum() / power.sum())


def test_the_controllers_law_is_the_fmus(four_link, identification_log):
    """Torque of the log = law(r, e) + feed-forward + the torque that holds the arm at the start."""
    signal = {
        s: identification_log.signals([f"joint{k}.{s}" for k in range(1, 5)]) for s in ("r", "e", "tau")
    }
    torque = controller_torque(four_link.controller, signal["r"], signal["e"])
    rest = signal["tau"] - torque - identification_log.frame[FEEDFORWARD].to_numpy()
    np.testing.assert_allclose(rest, np.broadcast_to(rest[0], rest.shape), atol=1e-6)
