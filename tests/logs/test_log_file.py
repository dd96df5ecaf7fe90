"""A log that stays on disk gives the numbers of the same log in memory."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from statsmodels.stats.sandwich_covariance import S_hac_simple

from flexmodels.files.robot_file import load_robot
from flexmodels.gearing import Transmission
from flexmodels.settings.processing import Processing
from pyident.conditioning import windows as conditioned_file
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.conditioning.windows import ConditionedFile, prepared
from pyident.estimation.estimator import reweighted, weighted
from pyident.estimation.identify import identify
from pyident.estimation.newey_west import LongRun
from pyident.logs import disk as log_file
from pyident.logs.foreign import open_robot_log, robot_log
from pyident.logs.log import Log, LogError, read_log, write_log
from pyident.regression.equations import Problem


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(log_file, "ROWS", 700)
    monkeypatch.setattr(conditioned_file, "ROWS", 500)


def close(found: np.ndarray, want: np.ndarray, rtol: float = 1e-10) -> None:
    np.testing.assert_allclose(found, want, rtol=0, atol=rtol * np.abs(want).max(axis=0).max())


def motor_log(samples: int = 20_011) -> Log:
    """Of one axis, smooth, a reversal every second or so."""
    time = np.arange(samples) * 1e-3
    q = 0.1 * np.sin(2 * np.pi * 0.4 * time) + 0.02 * np.sin(2 * np.pi * 1.7 * time + 1)
    tau = 30 * np.gradient(np.gradient(q, time), time) + 20 * np.sign(np.gradient(q, time))
    return Log(pd.DataFrame({"time": time, "joint1.e": q, "joint1.tau": tau}), "motor")


PLANS = [
    Processing(),
    Processing(derivative="hat"),
    Processing(cutoff=100.0, order=4),
    Processing(cutoff=100.0, order=4, decimate=50),
    Processing(decimate=7),
]


@pytest.mark.parametrize("plan", PLANS, ids=repr)
@pytest.mark.parametrize("ending", [".csv", ".parquet"])
def test_the_equations_are_those_of_the_log_in_memory(plan, ending, tmp_path):
    robot = load_robot("emps").with_settings(processing=plan)
    path, log = tmp_path / f"log{ending}", motor_log()
    write_log(log, path)
    file = prepared(log_file.log_file(path), robot)
    assert isinstance(file, ConditionedFile)
    assert len(list(file.pieces())) > 1
    whole, streamed = (
        [(A.copy(), y.copy()) for A, y in Problem(robot, (part,)).blocks()]
        for part in (condition(log, robot), file)
    )
    for i in (0, 1):
        want, found = (np.concatenate([block[i] for block in blocks]) for blocks in (whole, streamed))
        assert found.shape == want.shape
        close(found, want)


def test_a_law_that_remembers_gets_the_whole_log(tmp_path):
    robot = load_robot("emps").with_effect(1, "presliding")
    write_log(motor_log(), tmp_path / "log.parquet")
    (part,) = [prepared(log_file.log_file(tmp_path / "log.parquet"), robot)]
    assert isinstance(part, Conditioned)
    np.testing.assert_array_equal(part.motion.q, condition(motor_log(), robot).motion.q)


def test_long_logs_of_motors_are_referred_to_the_joints(tmp_path, monkeypatch):
    monkeypatch.setattr(log_file, "LARGE", 1000)
    robot = load_robot("emps")
    gears = Transmission(ratio=((-20.0,),), offset=(0.1,))
    geared = replace(robot, transmission=gears).with_settings(columns={})
    log = motor_log(2000)
    write_log(log, tmp_path / "joint.csv")
    turned = log.frame.rename(columns={"joint1.e": "motor1.q", "joint1.tau": "motor1.tau"})
    write_log(Log(turned, "motor"), tmp_path / "motor.csv")
    assert isinstance(open_robot_log(tmp_path / "joint.csv", geared), log_file.LogFile)
    found = open_robot_log(tmp_path / "motor.csv", geared)
    assert isinstance(found, Log)
    want = log.frame["joint1.e"] / -20 + 0.1
    np.testing.assert_allclose(found.frame["joint1.e"], want, rtol=1e-12)
    pd.testing.assert_frame_equal(found.frame, robot_log(tmp_path / "motor.csv", geared).frame)


@pytest.mark.parametrize("estimator", [weighted, reweighted])
def test_identify_gives_the_same_from_disk(four_link, identification_log, tmp_path, estimator):
    log = Log(identification_log.frame.head(2500), "short")
    write_log(log, tmp_path / "log.parquet")
    file = log_file.log_file(tmp_path / "log.parquet")
    want, found = (identify(four_link, [of], estimator) for of in (log, file))
    assert found.reduced.samples == want.reduced.samples
    assert found.solution.rank == want.solution.rank
    normal = [np.einsum("cip,ciq->pq", x.reduced.triangles, x.reduced.triangles) for x in (found, want)]
    close(normal[0], normal[1])
    seen = want.solution.seen.T * want.solution.scale
    np.testing.assert_allclose(seen @ found.solution.p, seen @ want.solution.p, rtol=1e-6, atol=1e-6)
    spread = [np.diag(seen @ x.solution.covariance @ seen.T) for x in (found, want)]
    np.testing.assert_allclose(spread[0], spread[1], rtol=1e-6)


def test_short_logs_are_read_into_memory(tmp_path, monkeypatch):
    path = tmp_path / "log.parquet"
    write_log(motor_log(2000), path)
    assert isinstance(log_file.open_log(path), Log)
    monkeypatch.setattr(log_file, "LARGE", 1000)
    file = log_file.open_log(path)
    assert isinstance(file, log_file.LogFile)
    assert (len(file), file.names) == (2000, ("time", "joint1.e", "joint1.tau"))
    assert file.period == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f.drop(columns="time"), "column time is missing"),
        (lambda f: f.assign(**{"joint1.e": f["joint1.e"].where(f.index != 1500)}), "not finite.* row 1501"),
        (lambda f: f.drop(index=1500), "time goes from 1.499 s to 1.501 s at row 1501"),
        (lambda f: f.drop(index=1400), "time goes from 1.399 s to 1.401 s at row 1401"),
        (lambda f: f.drop(index=700), "time goes from 0.699 s to 0.701 s at row 701"),
        (lambda f: f.head(1), "1 samples are too few"),
        (lambda f: f.assign(note="text"), "column note holds nothing that is a number"),
        (lambda f: pd.concat([f, f[["joint1.e"]]], axis=1), "column joint1.e is there twice"),
    ],
)
@pytest.mark.parametrize("reader", [log_file.log_file, read_log], ids=["disk", "memory"])
def test_a_wrong_log_is_explained(change, words, reader, tmp_path):
    change(motor_log(2500).frame).to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(LogError, match=words):
        reader(tmp_path / "log.csv")


def test_the_long_run_covariance_is_that_of_newey_and_west():
    scores = np.random.default_rng(4).normal(size=(500, 3)).cumsum(axis=0)
    meat = LongRun(3, lags=11)
    for start, stop in ((0, 5), (5, 300), (300, 301), (301, 500)):
        meat.add(scores[start:stop])
    np.testing.assert_allclose(meat.sum, S_hac_simple(scores, nlags=11), rtol=1e-11)
