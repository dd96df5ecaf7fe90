"""Laws of time count from a log's start, whatever the recorder's clock said."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import analytic_log, free_joint

from pyident.conditioning.weak_form import REACH, condition
from pyident.estimation.identify import identify
from pyident.extension.split import split
from pyident.logs.disk import log_file
from pyident.logs.log import Log, write_log

RATE = 0.05  # N m/s that the torque drifts


def begin(log: Log) -> float:
    """Time of the first equation."""
    time = condition(log, free_joint()).motion.time
    assert time is not None
    return float(time[0])


def later(log: Log, start: float) -> Log:
    """The same on a clock that had run before."""
    return replace(log, frame=log.frame.assign(time=log.frame["time"] + start))


@pytest.mark.parametrize("start", [0.0, 1234.5, 3.4e5])
def test_a_log_begins_at_zero(start):
    log = later(analytic_log(4.0), start)
    assert begin(log) == pytest.approx(REACH * log.period, abs=1e-6)


def test_what_is_held_out_of_a_log_goes_on_where_the_rest_ended():
    whole = later(analytic_log(6.0), 1234.5)
    (rest,) = split([whole], []).unseen
    assert begin(rest) == pytest.approx(4.0 + REACH * whole.period, abs=2 * whole.period)


@pytest.mark.parametrize("on_disk", [False, True])
def test_logs_of_different_clocks_tell_one_drift(on_disk, tmp_path):
    robot = free_joint().with_effect(1, "offset_drift").with_effect(1, "offset")
    logs = []
    for i, start in enumerate((0.0, 1234.5)):
        log = analytic_log(20.0, torque_noise=0.02, seed=i)
        drifts = log.frame["joint1.tau"] + RATE * log.frame["time"] + 0.3
        log = later(replace(log, frame=log.frame.assign(**{"joint1.tau": drifts})), start)
        if on_disk:
            write_log(log, tmp_path / f"{i}.parquet")
        logs.append(log_file(tmp_path / f"{i}.parquet") if on_disk else log)
    found = identify(robot, logs)
    values = dict(zip(found.reduced.columns, found.solution.p, strict=True))
    assert values["joint1.offset_drift.rate"] == pytest.approx(RATE, rel=0.02)
    assert values["joint1.offset"] == pytest.approx(0.3, rel=0.05)
    assert np.isfinite(found.solution.std).any()
