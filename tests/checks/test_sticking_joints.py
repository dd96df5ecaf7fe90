"""Friction that holds for a while where joints turn round is no torque that comes late."""

import numpy as np
import pytest
from six_axis_logs import COULOMB, VISCOUS, arm, late, made

from pyident.checks.balances import balances, samples
from pyident.checks.check_log import check_log
from pyident.checks.timing import common_delay

HELD = 0.12  # s that a joint sticks, or its friction turns round


def sticking(q: np.ndarray, v: np.ndarray, load: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Friction ramps from one sign to the other while a joint's speed has just turned."""
    count = round(HELD / (time[1] - time[0]))
    ramp = np.ones(count) / count
    signs = [np.convolve(sign, ramp)[: len(time)] for sign in np.sign(v).T]
    return COULOMB * np.column_stack(signs) + VISCOUS * v


@pytest.mark.parametrize("seed", range(3))
def test_it_is_not_late(seed):
    """As smoothed by a filter that rings every torque had seemed one to four samples late."""
    log = made(arm(), seed, sticking, 20.0)
    assert not [d.sentence for d in check_log(arm(), log) if d.kind == "delay"]


def test_a_delay_beside_it_is_measured():
    log = late(made(arm(), 0, sticking, 20.0, 3.0), -2.0)
    signals = samples(arm(), log)
    assert signals is not None
    told = common_delay(balances(signals).in_motion)
    assert told is not None
    assert told.shift == pytest.approx(2.0, abs=0.4)
