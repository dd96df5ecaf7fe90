"""Whether what a moved torque leaves is that of a delay, or the rest of a ripple."""

from typing import Any, cast

import numpy as np
import pytest

from pyident.checks import timing

NOBODY = cast(Any, None)


@pytest.mark.parametrize(
    ("left", "so"),
    [
        (lambda away: 0.001 + 1e-5 * away**2, True),  # a smooth torque
        (lambda away: 0.001 + 2e-4 * away, True),  # steps of friction
        (lambda away: 0.002 + 0.0042 * np.minimum(away / 22, 1), False),  # a ripple: no more than all of it
        (lambda away: np.minimum(0.01 * away, 0.15), True),  # a motion so fast that nothing belongs together
    ],
)
def test_a_delay_leaves_ever_more_the_further_a_torque_is_moved(left, so, monkeypatch):
    monkeypatch.setattr(timing, "energies", lambda of, k, shifts: left(np.abs(shifts - 11.0)))
    assert timing._grows(NOBODY, 0, 11.0) == so
