"""The filter of a known noise is found; under slow noise values scatter less than those of least squares."""

import numpy as np
import pytest
from analytic_joint import COULOMB, VISCOUS, analytic_log, free_joint
from scipy.signal import lfilter

from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import predicting, weighted
from pyident.estimation.prediction_error import Whitened, noise_filters, prediction_error
from pyident.logs.log import Log
from pyident.regression.equations import Problem

NAMES = ("joint1.viscous", "joint1.coulomb")


def with_slow_noise(seed: int) -> Problem:
    """Torque noise whose memory is 0.2 s, against which least squares has no defence."""
    log = analytic_log(torque_noise=0.002, seed=seed)
    white = np.random.default_rng(1000 + seed).standard_normal(len(log.frame))
    tau = log.frame["joint1.tau"] + 0.02 * np.asarray(lfilter([1.0], [1.0, -0.98], white))
    return Problem(
        free_joint(), (condition(Log(log.frame.assign(**{"joint1.tau": tau}), "slow"), free_joint()),)
    )


def friction(found) -> np.ndarray:
    return found.solution.p[[found.reduced.columns.index(n) for n in NAMES]]


def test_the_coefficients_of_an_autoregressive_process_are_found():
    """x(k) = 1.2 x(k-1) - 0.5 x(k-2) + e(k), in two logs."""
    white = np.random.default_rng(0).standard_normal((2, 20_000))
    logs = [np.asarray(lfilter([1.0], [1.0, -1.2, 0.5], e))[:, None] for e in white]
    (found,) = noise_filters(logs)
    assert len(found) == 3
    assert found == pytest.approx([1.0, -1.2, 0.5], abs=0.02)


def test_white_noise_and_none_ask_for_no_filter():
    white = np.random.default_rng(0).standard_normal((20_000, 1))
    assert len(noise_filters([white])[0]) == 1
    assert noise_filters([np.zeros((100, 1))])[0] == pytest.approx([1.0])


def test_values_scatter_less_than_those_of_least_squares_and_are_right():
    problems = [with_slow_noise(seed) for seed in range(8)]
    errors = {
        estimator: np.array([friction(estimator(problem)) for problem in problems]) - [VISCOUS, COULOMB]
        for estimator in (weighted, predicting)
    }
    rms = {estimator: np.sqrt(np.mean(values**2, axis=0)) for estimator, values in errors.items()}
    assert (rms[predicting] < rms[weighted]).all()
    assert rms[predicting][0] < 0.7 * rms[weighted][0]


def test_prediction_errors_have_no_memory():
    whitened, _, solution = prediction_error(with_slow_noise(0))
    (left,) = whitened.residuals(solution.p)
    left = left[np.abs(left[:, 0]) > 0, 0]
    lagged = [float(left[k:] @ left[:-k] / (left @ left)) for k in range(1, 6)]
    assert np.abs(lagged).max() < 4 / np.sqrt(len(left))


def test_an_equation_out_of_use_takes_those_with_it_that_need_it():
    """Filtered by hand, and none that reaches over a gap."""
    problem = with_slow_noise(1)
    D = np.array([1.0, -0.9, 0.2])
    A, y = (
        np.concatenate(parts) for parts in zip(*((A.copy(), y) for A, y in problem.blocks()), strict=True)
    )
    whitened = Whitened(problem.robot, problem.parts, (D,))
    B, z = (
        np.concatenate(parts) for parts in zip(*((A.copy(), y) for A, y in whitened.blocks()), strict=True)
    )
    used = np.asarray(A[:, 0].any(axis=1))
    known = used[2:] & used[1:-1] & used[:-2]
    assert 0 < known.sum() < len(known)
    np.testing.assert_allclose(B[2:][known], (A[2:] - 0.9 * A[1:-1] + 0.2 * A[:-2])[known], atol=1e-12)
    np.testing.assert_allclose(z[2:][known], (y[2:] - 0.9 * y[1:-1] + 0.2 * y[:-2])[known], atol=1e-12)
    assert not B[2:][~known].any()
    assert not B[:2].any()
