"""Floors of replicas, and the balance of equations of which one lacks something."""

from typing import Any

import numpy as np
import pytest
from six_axis_logs import arm, made, three_laws
from two_link_logs import in_process, loaded, made_log, two_link

from pyident.diagnosis.base.balance import _unlikely, raised_floors
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.base.replicas import left_of, replicated
from pyident.diagnosis.base.setting import set_up, unbiased, workers_of
from pyident.diagnosis.searched import searched, weighed_anew
from pyident.regression.spectrum import Band, Equations, Floor, floors
from pyident.simulation.replica import Repeat


def test_noise_of_encoders_is_no_floor_at_low_frequencies(tmp_path):
    """A regression with one weight for all frequencies lets it bend the parameters, where physics is."""
    robot = two_link()
    with loaded(robot, tmp_path) as fmu:
        quiet = made_log(fmu, robot, 0)
    setting = set_up(robot, [_noisier(quiet, 2e-5)])
    with workers_of(setting, in_process) as workers:
        setting = unbiased(setting, workers)
        ((logs, bands, left),) = workers.submit(replicated, setting, [1]).result()
    assert all(isinstance(r, Repeat) for r in setting.repeats)
    own, flat = (floors(bands, of, 1)[0] for of in (left, left_of(setting, logs)[1]))
    low = [_rms(level, 0.2, 1.0) for level in (own, flat)]
    between = _rms(own, 2.0, 4.0)
    assert (low[0] < 3 * between).all()
    assert (low[1] > 5 * low[0]).any()


def _noisier(log: Any, sigma: float) -> Any:
    rng = np.random.default_rng(1)
    frame = log.frame.copy()
    for name in ("joint1.e", "joint2.e"):
        frame[name] += sigma * rng.standard_normal(len(frame))
    return type(log)(frame, log.source)


def _rms(level: Floor, low: float, high: float) -> np.ndarray:
    inside = (level.frequencies >= low) & (level.frequencies < high)
    return np.sqrt(np.mean(level.rms[:, inside] ** 2, axis=1))


@pytest.mark.parametrize("lacks", [10.0, 1e4])
def test_an_equation_that_lacks_something_leaves_its_neighbours_alone(lacks):
    """Two equations share parameters, one has a force of `lacks` floors that none of them makes."""
    rng, bins = np.random.default_rng(0), 400
    A = rng.standard_normal((2, 2 * bins, 4))
    p = np.array([3.0, -2.0, 1.0, 5.0])
    missing = np.abs(rng.standard_normal(2 * bins)) + 0.5 * A[1, :, 0]
    y = A @ p + rng.standard_normal((2, 2 * bins))
    y[1] += lacks * missing
    data = Equations(None, Band(4 * bins, bins, 0.01), A, y)  # pyright: ignore[reportArgumentType]
    raised = raised_floors([data], p)
    base = solve_base([data.over(raised[:, None])])
    assert np.square(base.residual[0][0]).mean() == pytest.approx(1.0, abs=0.15)
    assert raised[0] == pytest.approx(1.0, rel=0.05)
    assert raised[1] > 0.5 * lacks
    assert base.p == pytest.approx(p, abs=0.2)


def test_equations_without_a_torque_are_not_solved_by_nothing():
    """Two bodies on springs share a mass; in the second half of the data they carry more, 300 floors."""
    rng, bins = np.random.default_rng(1), 400
    motion = rng.standard_normal((3, 2 * bins))
    heavier = np.repeat([1.0, 1.6], bins)
    A, y, p = np.zeros((3, 2 * bins, 4)), np.zeros((3, 2 * bins)), np.array([300.0, 500.0, 400.0, 600.0])
    A[0, :, 0], A[0, :, 1] = motion[0], motion[1]  # the motor: its own inertia and the mass
    y[0] = p[0] * motion[0] + heavier * p[1] * motion[1] + rng.standard_normal(2 * bins)
    for row in (1, 2):  # mass times its acceleration, less the spring's moment
        A[row, :, 1] = motion[1]
        A[row, :, 1 + row] = -heavier * p[1] * motion[1] / p[1 + row] + 1e-3 * rng.standard_normal(2 * bins)
    data = Equations(None, Band(4 * bins, bins, 0.01), A, y)  # pyright: ignore[reportArgumentType]
    raised = raised_floors([data], p)
    found = solve_base([data.over(raised[:, None])]).p
    assert np.all(found[1:] > 0.5 * p[1:])


def test_equations_below_their_floor_are_no_better_than_at_it():
    """Equations without a torque leave nothing where all parameters are zero."""
    assert _unlikely(np.array([1.0, 1.0])) == pytest.approx(0.0)
    assert _unlikely(np.array([5.0, 1.0])) == pytest.approx(np.log(5.0))
    assert _unlikely(np.array([1.0, 0.1])) > _unlikely(np.array([5.0, 1.0]))


def test_floors_are_raised_by_what_is_left_beside_a_law_that_is_named():
    logs = [made(arm(), seed, three_laws) for seed in range(2)]
    search = searched(arm(), logs, never)
    laws = [search.best("load_dependent_friction", k) for k in (2, 3)]
    laws += [search.best("nonlinear_viscous", 1)]
    again = weighed_anew(search, [law.candidate for law in laws if law], never, lambda _: None)
    assert search.examination.raised[:3].max() > 3.0
    assert again.examination.raised == pytest.approx(np.ones(6), abs=0.2)
    assert again.examination.energy[1].mean() > search.examination.energy[1].mean()


def never(_: Any) -> Any:
    raise AssertionError("without a known controller nothing is simulated")
