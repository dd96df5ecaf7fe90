"""Pushes of a person, which a floor takes for slow noise, are told from noise by when they come."""

from dataclasses import replace

import numpy as np
import pytest
from six_axis_logs import arm, made

from pyident.diagnosis.notes import of_bursts
from pyident.diagnosis.searched import searched
from pyident.diagnosis.unexplained.bursts import bursts
from pyident.diagnosis.verdict import sentence_of
from pyident.logs.log import Log

JOINT, PUSH = 2, 12.0  # N m
TIMES = (6.5, 13.5, 21.5)  # s


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def pushed(log: Log) -> Log:
    """At three times of the log, for half a second each; the second time the hardest."""
    time, name = log.frame["time"].to_numpy(), f"joint{JOINT}.tau"
    course = sum(
        size * np.exp(-(((time - at) / 0.25) ** 2)) for at, size in zip(TIMES, (1, -1.6, 1), strict=True)
    )
    return replace(log, frame=log.frame.assign(**{name: log.frame[name] + PUSH * course}))


def left(search, row):
    return bursts(search.examination.logs, [r[row] for r in search.base.residual], row)


@pytest.mark.slow
def test_they_are_found_with_the_time_of_the_hardest():
    search = searched(arm(), [pushed(made(arm(), 0))], never)
    found = left(search, JOINT - 1)
    assert found is not None
    assert found.share > 0.6
    assert found.count == len(TIMES)
    assert found.start == pytest.approx(TIMES[1], abs=1.0)
    (note,) = of_bursts(search, {JOINT - 1: found})
    assert f"joint{JOINT}" in note
    assert "3 bursts, the strongest at 13 s of log 0" in note
    assert "comes in bursts" in sentence_of("nothing_detectable", (), (), ("", ""), (), ["joint2"])


@pytest.mark.slow
def test_noise_is_none():
    search = searched(arm(), [made(arm(), seed) for seed in (1, 2)], never)
    assert [left(search, row) for row in range(6)] == [None] * 6
