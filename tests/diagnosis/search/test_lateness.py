"""Positions that all come late are found by themselves, and what is missing besides behind them."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import CubicSpline
from six_axis_logs import arm, made, plain, three_laws

from pyident.diagnosis.diagnose import concluded, searched
from pyident.diagnosis.lateness import earlier, lateness
from pyident.logs.log import Log

LATE = 0.9  # samples
PACE = 6.0  # of a slow motion, whose torques hardly change in a sample


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def late(log: Log, samples: float) -> Log:
    time = log.frame["time"].to_numpy()
    names = [name for name in log.frame if name.endswith(".e")]
    moved = {n: CubicSpline(time, log.frame[n])(time - samples * log.period) for n in names}
    return replace(log, frame=log.frame.assign(**moved).iloc[5:-5].reset_index(drop=True))


def logs_of(friction, samples: float) -> list[Log]:
    return [late(made(arm(), seed, friction, 20.0, PACE), samples) for seed in range(3)]


@pytest.mark.parametrize("samples", [LATE, -LATE])
def test_the_time_is_found_and_nothing_else(samples):
    logs = logs_of(plain, samples)
    search = searched(arm(), logs[:2], never)
    assert search.examination.setting.late == pytest.approx(samples * logs[0].period, rel=0.15)
    found = concluded(search, never, logs[2:])
    assert found.verdict == "nothing_detectable"
    way = "late" if samples > 0 else "early"
    assert f"ms {way} against the torques. That put right: Nothing is missing" in found.sentence
    assert any("give their columns a delay" in note for note in found.notes)


def test_laws_behind_it_are_named():
    logs = logs_of(three_laws, LATE)
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    firsts = {(f.tie[0].effect, f.tie[0].joint) for f in found.findings}
    assert {("load_dependent_friction", "joint2"), ("nonlinear_viscous", "joint1")} <= firsts
    assert not any(n.effect == "torque_delay" for f in found.findings for n in f.tie)


def test_positions_in_time_stay_there():
    search = searched(arm(), logs_of(three_laws, 0.0)[:2], never)
    assert search.examination.setting.late == 0.0
    assert lateness(search.examination) == 0.0


def test_a_log_moved_there_and_back_is_itself():
    log = made(arm(), 0, plain, 5.0, PACE)
    for samples in (2.0, -2.0):
        again = earlier(arm(), late(log, samples), samples * log.period)
        both = log.frame.iloc[20:-20].merge(again.frame, on="time", suffixes=("", ".again"))
        assert len(both) == len(log.frame) - 40
        np.testing.assert_allclose(both["joint2.e.again"], both["joint2.e"], atol=1e-4)


def test_a_moved_log_goes_straight_on_where_it_ends():
    time = np.arange(50) * 0.01
    frame = pd.DataFrame({"time": time} | {f"joint{k}.e": k * time for k in range(1, 7)})
    for moved in (0.033, -0.033):
        found = earlier(arm(), Log(frame, "line"), moved).frame
        np.testing.assert_allclose(found["joint3.e"], 3 * (time + moved), atol=1e-12)
