"""Torques that are moved in time tell the same as positions that are."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from six_axis_logs import arm, late, made, plain

from pyident.conditioning.alignment import Alignment
from pyident.diagnosis.base.projection import residuals_of, solve_base
from pyident.diagnosis.moved_torques import moved, typical
from pyident.simulation.denoised import denoised_equations, where_moving

PACE = 4.0  # of a slow motion, whose torques hardly change in a sample


@pytest.mark.parametrize("samples", [2.7, -0.4])
def test_they_leave_what_a_new_fit_of_moved_positions_leaves(samples):
    """A new fit has all columns along the moved positions; ends and bends of the torques differ."""
    robot, logs = arm(), [late(made(arm(), seed, plain, 12.0, PACE), samples) for seed in range(2)]
    data, period = denoised_equations(robot, logs), logs[0].period
    base, levels = solve_base(data), [np.ones(e.y.shape) for e in data]
    moving = where_moving(robot, logs, data)

    def by_torques(time: float) -> float:
        return typical(moved(data, levels, base, time), moving)

    def by_positions(time: float) -> float:
        return typical(residuals_of(denoised_equations(robot, Alignment(time).of_all(robot, logs))), moving)

    assert by_torques(0.0) == pytest.approx(by_positions(0.0), rel=1e-9)
    for time in (0.5 * samples * period, samples * period, 1.5 * samples * period):
        assert by_torques(time) == pytest.approx(by_positions(time), rel=0.05)
    found: Any = minimize_scalar(
        by_torques, bounds=(-5 * period, 5 * period), options={"xatol": 0.01 * period}
    )
    assert found.x == pytest.approx(samples * period, abs=0.05 * period)


def test_what_a_move_changes_of_two_torques_is_the_sum():
    """Weights that hang on the data had spread loud noise of high frequencies over low ones."""
    robot, log, rng = arm(), made(arm(), 0, plain, 12.0, PACE), np.random.default_rng(0)
    data = denoised_equations(robot, [log])
    base, levels = solve_base(data), [np.ones(e.y.shape) for e in data]

    def change(torque: np.ndarray) -> np.ndarray:
        (e,) = data
        other = replace(e, part=replace(e.part, target=torque))
        return moved([other], levels, base, 0.3 * log.period)[0] - base.residual[0]

    torque = data[0].part.target
    noise = rng.standard_normal(torque.shape)
    assert change(torque + noise) == pytest.approx(change(torque) + change(noise), abs=1e-9)
