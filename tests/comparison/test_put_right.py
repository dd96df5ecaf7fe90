"""A rigid arm in a loop that nobody knows: positions that all come late are no failure of its model."""

from dataclasses import replace

from scipy.interpolate import CubicSpline
from six_axis_logs import arm, made, plain, three_laws

import pyident as pi
from pyident.logs.log import Log

LATE = 0.9  # samples


def late(log: Log) -> Log:
    """The log with all positions late, without the ends at which nothing tells them."""
    time = log.frame["time"].to_numpy()
    names = [name for name in log.frame if name.endswith(".e")]
    moved = {n: CubicSpline(time, log.frame[n])(time - LATE * log.period) for n in names}
    return replace(log, frame=log.frame.assign(**moved).iloc[5:-5].reset_index(drop=True))


def compared(friction) -> pi.Compared:
    logs = [late(made(arm(), seed, friction, 20.0, 6.0)) for seed in range(2)]
    return pi.compare(pi.identify(arm(), logs).robot, logs)


def test_late_positions_are_put_right_and_said():
    found = compared(plain)
    assert not found.comparison.structural, found.comparison.sentence
    assert [note for note in found.notes if "late against the torques; that was put right" in note]
    for bin in found.comparison.refitted:
        assert bin.kind != "all" or 0.7 < bin.ratio < 1.4, bin.coordinate


def test_what_is_missing_beside_still_stands_out():
    where = compared(three_laws).comparison.where
    assert where is not None
    assert where.ratio > 2
