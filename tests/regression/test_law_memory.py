"""States of laws along a log, against the exponential and SciPy's integrator."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from pyident.regression.law_memory import equilibrium, filtered, hat_means

H = np.array([0.01, 0.02, 0.01, 0.03])
A = np.array([-3.0, -0.5, 0.0, -200.0])  # stiff and free intervals
B = np.array([[1.0, -2.0, 4.0, 50.0], [3.0, -2.0, 0.0, -400.0]])  # at the beginning and the end


def _exact(start, samples):
    """z(t) at any times, by an integrator that knows nothing of exponentials."""
    edges = np.concatenate([[0.0], np.cumsum(H)])

    def rate(t, z):
        i = min(int(np.searchsorted(edges, t, side="right")) - 1, len(H) - 1)
        share = (t - edges[i]) / H[i]
        return A[i] * z + (1 - share) * B[0, i] + share * B[1, i]

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
    assert filtered(A[:0], B[:, :0], H[:0], 0.7).tolist() == [0.7]


def test_means_under_the_hat():
    """∫ hat z dt of one interval by quadrature: rising half at its end, falling half at its start."""
    a, b, c, h, start = -40.0, 3.0, 70.0, 0.02, 0.5  # z' = a z + b + c s

    def z(s):
        line = -(b + c / a + c * s) / a
        return (start + (b + c / a) / a) * np.exp(a * s) + line

    falling = quad(lambda s: (1 - s / h) * z(s), 0, h)[0] * 2 / h
    rising = quad(lambda s: s / h * z(s), 0, h)[0] * 2 / h
    one = np.array([a]), np.array([[b], [b + c * h]]), np.array([h])
    means = hat_means(filtered(*one, start), *one)
    assert means == pytest.approx([falling, rising], rel=1e-9)


def test_a_memory_far_shorter_than_a_sample_follows_what_it_is_told():
    u = np.sin(np.arange(0, 3, 0.01))
    delay = 1e-4
    z = filtered(
        np.full(len(u) - 1, -1 / delay), np.array([u[:-1], u[1:]]) / delay, np.full(len(u) - 1, 0.01), 0.0
    )
    assert z[1:] == pytest.approx(u[1:] - delay * np.diff(u) / 0.01, abs=1e-12)


def test_rest():
    assert equilibrium(-2.0, 3.0) == 1.5
    assert equilibrium(0.0, 3.0) == 0.0
