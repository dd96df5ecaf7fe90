"""A rigid arm in a loop that nobody knows: positions that all come late are no failure of its model."""

import pytest
from six_axis_logs import arm, late, made, plain, three_laws

import pyident as pi

LATE = 0.9  # samples


def compared(friction) -> pi.Compared:
    logs = [late(made(arm(), seed, friction, 20.0, 6.0), LATE) for seed in range(2)]
    return pi.compare(pi.identify(arm(), logs).robot, logs)


def test_late_positions_are_put_right_and_said():
    found = compared(plain)
    assert not found.comparison.structural, found.comparison.sentence
    assert [note for note in found.notes if "late against the torques; that was put right" in note]
    for bin in found.comparison.refitted:
        assert bin.kind != "all" or 0.7 < bin.ratio < 1.4, bin.coordinate


@pytest.mark.slow
def test_what_is_missing_beside_still_stands_out():
    where = compared(three_laws).comparison.where
    assert where is not None
    assert where.ratio > 2
