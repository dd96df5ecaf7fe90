"""States of laws along a log, against the exponential and SciPy's integrator."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from pyident.regression.law_memory import equilibrium, filtered, hat_means

H = np.array([0.01, 0.02, 0.01, 0.03])
A = np.array([-3.0, -0.5, 0.0, -200.0])  # stiff and free intervals
B = np.array([1.0, -2.0, 4.0, 50.0])


def _exact(start, samples):
    """z(t) at any times, by an integrator that knows nothing of exponentials."""
    edges = np.concatenate([[0.0], np.cumsum(H)])

    def rate(t, z):
        i = min(int(np.searchsorted(edges, t, side="right")) - 1, len(H) - 1)
        return A[i] * z + B[i]

    out, z, at = [], np.array([start]), 0.0
    for t in samples:
        for edge in [e for e in edges if at < e < t]:
            z = solve_ivp(rate, (at, edge - 1e-15), z, rtol=1e-10, atol=1e-12, method="LSODA").y[:, -1]
            at = edge
        if t > at:
            z = solve_ivp(rate, (at, t - 1e-15), z, rtol=1e-10, atol=1e-12, method="LSODA").y[:, -1]
            at = t
        out.append(float(z[0]))
    return np.array(out)


def test_states_follow_the_rate():
    edges = np.concatenate([[0.0], np.cumsum(H)])
    assert filtered(A, B, H, 0.7) == pytest.approx(_exact(0.7, edges), rel=1e-7)


def test_a_single_sample_has_the_state_it_starts_with():
    assert filtered(A[:0], B[:0], H[:0], 0.7).tolist() == [0.7]


def test_means_under_the_hat():
    """∫ hat z dt of one interval by quadrature: rising half at its end, falling half at its start."""
    a, b, h, start = -40.0, 3.0, 0.02, 0.5

    def z(s):
        return (start + b / a) * np.exp(a * s) - b / a

    falling = quad(lambda s: (1 - s / h) * z(s), 0, h)[0] * 2 / h
    rising = quad(lambda s: s / h * z(s), 0, h)[0] * 2 / h
    one = np.array([a]), np.array([b]), np.array([h])
    means = hat_means(filtered(*one, start), *one)
    assert means == pytest.approx([falling, rising], rel=1e-9)


def test_rest():
    assert equilibrium(-2.0, 3.0) == 1.5
    assert equilibrium(0.0, 3.0) == 0.0
