"""The covariance of sums of instrument times residual, from the residual's spectrum.

The covariance of an instrumental estimate is a sandwich, here in the frequency domain. A sum over samples of
instrument times residual is a sum over frequencies, and its variance needs the residual's spectrum where the
instruments have theirs: the periodogram, smoothed over neighbouring bins, with all its correlations between
equations. Lags in time would let the noise of high frequencies, which differences raise as f squared, leak
into it. A part of a log that does not count, as where a joint rests, has no instruments and says nothing of
the noise. A slow motion is in a few bins, and as many parameters leave less there than there was: the
residual is divided by what its leverage leaves (HC3 of MacKinnon and White 1985).
"""

from collections.abc import Sequence

import numpy as np

from flexmodels.threads import gathered
from pyident.estimation.instrumental_variables import Logs, MomentEquations, Rows, Scatter

_BINS = 8  # neighbours on either side over which the periodogram is smoothed
_MOST = 0.8  # of the noise in a bin that a fit is believed to have taken up
_NEAR = 1 - np.abs(np.arange(-_BINS, _BINS + 1)) / (_BINS + 1)
_SMOOTH = 51  # bins of `smoothed_power`: two of noise that is alike agree within a fifth
_EXCESS = 1.2  # times the power of noise: less is not told from it
_LINES = 2000  # of a spectrum at a time: they fit into memory


def spectral(
    logs: Logs,
    weights: np.ndarray,
    counted: Sequence[np.ndarray] | None = None,
    fitted: np.ndarray | None = None,
) -> Scatter:
    """The covariance of the sums of instrument times residual, from the residual's spectrum.

    counted   per log (transform_length(N) // 2 + 1, n): share of the residual's amplitude that counts;
              none: all of it
    fitted    (P, r) makes of instruments the orthonormal columns whose fit left the residual; none: no fit
    """
    return lambda turn, p: _spectral(logs, weights, turn, p, counted, fitted)


def of_fit(equations: MomentEquations) -> Scatter:
    """`spectral` of the residual that the solution of these equations leaves."""
    return spectral(equations.logs, equations.weights, fitted=equations.turn)


def transform_length(samples: int) -> int:
    """To which signals are continued with zeros before they are transformed: it has small factors only."""
    from scipy.fft import next_fast_len

    length = next_fast_len(samples, real=True)
    assert length is not None
    return length


def smoothed_power(values: np.ndarray) -> np.ndarray:
    """(transform_length(N) // 2 + 1, n) periodograms of values (N, n), averaged over neighbouring bins."""
    from scipy.ndimage import uniform_filter1d

    lines = np.abs(np.fft.rfft(values, transform_length(len(values)), axis=0)) ** 2
    return uniform_filter1d(lines, _SMOOTH, axis=0, mode="nearest")


def beyond_noise(left: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Share of an amplitude that no noise accounts for; `smoothed_power` (bins, n) of residual and noise."""
    ratio = left / np.maximum(noise, 1e-300)
    return np.where(ratio < _EXCESS, 0.0, np.sqrt(1 - 1 / np.maximum(ratio, 1.0)))


def _spectral(
    logs: Logs,
    weights: np.ndarray,
    turn: np.ndarray,
    p: np.ndarray,
    counted: Sequence[np.ndarray] | None,
    fitted: np.ndarray | None,
) -> np.ndarray:
    def of_log(log: tuple[int, Rows]) -> np.ndarray:
        number, rows = log
        return _spectral_of(rows, weights, turn, p, None if counted is None else counted[number], fitted)

    return np.sum(gathered(of_log, enumerate(logs())), axis=0)


def _transformed(rows: Rows, weights: np.ndarray, turn: np.ndarray, N: int) -> np.ndarray:
    """(n, r, N // 2 + 1) conjugate transforms of instruments in directions turn (P, r), as they count."""
    X = np.empty((len(weights), turn.shape[1], N // 2 + 1), complex)
    for c, weight in enumerate(weights):
        np.conj(np.fft.rfft(weight * rows.share[:, c] * rows.turned(c, turn), N), out=X[c])
    return X


def _taken_up(X: np.ndarray, N: int, everywhere: np.ndarray) -> np.ndarray:
    """(N, n) share of the noise in a bin and its neighbours that a fit took up: its leverage.

    X           as of `_transformed`, of the fit's orthonormal columns
    everywhere  (n,) by which the amplitude of what counts is raised to that of all the time
    """
    from scipy.ndimage import convolve1d

    share = np.square(np.abs(X)).sum(axis=1) / N * everywhere[:, None] ** 2
    near = np.minimum(convolve1d(share, _NEAR / _NEAR.sum(), axis=1, mode="mirror"), _MOST)
    return np.concatenate([near, near[:, 1 : N - near.shape[1] + 1][:, ::-1]], axis=1).T


def _spectral_of(
    rows: Rows,
    weights: np.ndarray,
    turn: np.ndarray,
    p: np.ndarray,
    counted: np.ndarray | None,
    fitted: np.ndarray | None,
) -> np.ndarray:
    N = transform_length(len(rows.share))
    everywhere = np.sqrt(N / np.maximum(np.square(rows.share).sum(axis=0), 1e-300))
    v = np.fft.fft(rows.residual(p) * rows.share * weights * everywhere, N, axis=0)
    half = N // 2 + 1
    if counted is not None:
        v *= np.concatenate([counted, counted[1 : N - half + 1][::-1]])
    X = _transformed(rows, weights, turn, N)
    if fitted is not None:
        columns = X if fitted is turn else _transformed(rows, weights, fitted, N)
        v /= 1 - _taken_up(columns, N, everywhere)
    twice = np.full(half, 2.0)
    twice[0] = 1.0
    if N % 2 == 0:
        twice[-1] = 1.0
    near = np.stack([np.roll(v, -shift, axis=0)[:half] for shift in range(-_BINS, _BINS + 1)], axis=2)
    near *= np.sqrt(twice[:, None] * _NEAR / _NEAR.sum())[:, None, :] / N
    total = np.zeros((turn.shape[1], turn.shape[1]))
    for at in range(0, half, _LINES):
        lines = slice(at, at + _LINES)
        products = np.ascontiguousarray(X[:, :, lines].transpose(2, 1, 0)) @ near[lines]
        scores = np.ascontiguousarray(products.transpose(1, 0, 2)).view(float)  # real, imaginary
        scores = scores.reshape(turn.shape[1], -1)
        total += scores @ scores.T
    return total
