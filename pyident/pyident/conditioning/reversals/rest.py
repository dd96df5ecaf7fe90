"""Samples in which the sign of dry friction is not known: standstill, reversals, and near misses between two.

An equation holds a mean over its sample's hat, from the sample before to the one after. Dry friction is known
there only if the speed keeps its sign all the while. Means at the samples do not tell: a speed that falls to
zero and rises again between them never shows another sign, but friction acts against it for a part of the
time, and as another machine or simulator rounds it. So the speed is followed between the samples, too, by the
cubic through four of them.
"""

import numpy as np

AROUND = 2  # samples on either side of a reversal that are left out
REACH = AROUND + 3  # samples on either side on which the answer for one depends
STANDSTILL = 0.02  # of a joint's rms speed: slower is standstill
_ROUNDED = 2.65  # widths of a rounded sign: from there on it is ± 1 to a hundredth
_MOST_ROUNDED = 0.1  # of the rms speed: what is lost to that at most
_FAST = 0.2  # of a joint's highest speed: faster is moving
_CREEP = 0.05  # of its usual speed when moving
_LINGERS = 1.5  # times what passing through zero takes at the acceleration before and after it
_NOWHERE = 0.02  # of the way that it covers in the log
_WIDENED = 0.1  # of the samples
_BETWEEN = np.array([0.0, 0.25, 0.5, 0.75, 1.0])  # of an interval: where the speed is looked at


def at_samples(mean_speed: np.ndarray) -> np.ndarray:
    """Speeds at the samples from their means under hats, both (N, n): the mean is v + T² v̈ / 12 + O(T⁴)."""
    v = mean_speed.copy()
    v[1:-1] -= (mean_speed[2:] - 2 * mean_speed[1:-1] + mean_speed[:-2]) / 12
    return v


def away_from_rest(speed: np.ndarray, mean_square: float, width: float = 0.0) -> np.ndarray:
    """(N,): whether a joint with this speed (N,) keeps its direction around each sample.

    mean_square   of its speed over the whole log
    width         speed over which its law rounds the sign, which no machine does; 0: the law does not, either
    """
    usual = np.sqrt(mean_square)
    slow = max(STANDSTILL * usual, min(_ROUNDED * width, _MOST_ROUNDED * usual))
    turning = _rests_between(speed, slow)
    near = (np.abs(speed) < slow) | turning | np.roll(turning, 1)
    for _ in range(AROUND - 1):
        near[1:-1] = near[1:-1] | near[2:] | near[:-2]
    return ~near


def without_steps(known: np.ndarray, acceleration: np.ndarray, samples: int) -> np.ndarray:
    """`away_from_rest` (N,), with longer rests where dry friction makes the joint's acceleration (N,) a step.

    A motion that is followed closely turns round with the least jerk, and nothing is left out beside its
    rests. One that is not, in a loop that the friction disturbs, has its jerk there; a low pass spreads that
    over so many samples on either side, which are left out as well, a tenth of all at most: those of the
    largest jerks.
    """
    rests, may_go = stretches(~known), _WIDENED * len(known)
    jerk, further = np.abs(np.gradient(acceleration)), min(samples, int(may_go / (2 * max(len(rests), 1))))
    beside = np.zeros(len(known), bool)
    for end in rests.ravel().tolist():
        beside[max(end - further, 0) : end + further] = True
    usual = known & ~beside
    if not usual.any() or not beside.any() or np.median(jerk[beside]) <= np.median(jerk[usual]):
        return known
    sides = [(max(end - samples, 0), end) for end in rests[:, 0].tolist()]
    sides += [(end, end + samples) for end in rests[:, 1].tolist() if end < len(known)]
    kept = known.copy()
    for start, stop in sorted((s for s in sides if s[0] < s[1]), key=lambda s: -jerk[slice(*s)].max()):
        may_go -= np.count_nonzero(kept[start:stop])
        if may_go < 0:
            break
        kept[start:stop] = False
    return kept if kept.any() else known


def creeping(position: np.ndarray, speed: np.ndarray, period: float) -> np.ndarray:
    """(N,): whether a joint stands where it is, though it gives way to what the others do.

    position, speed   (N,) of the joint
    It is far slower than when it moves, for longer than it takes to turn round or stop at the pace before and
    after that, and gets nowhere: what it does then is decided by how a gear sticks, or a simulator rounds
    friction, and not by Coulomb's level.
    """
    fast = np.abs(speed) > _FAST * np.abs(speed).max()
    usual = float(np.sqrt(np.mean(speed[fast] ** 2))) if fast.any() else 0.0
    out = np.zeros(len(speed), bool)
    limit, pace = _CREEP * usual, np.abs(np.diff(speed)) / period
    nowhere = _NOWHERE * np.ptp(position)
    for start, stop in stretches(np.abs(speed) < limit):
        ends = [pace[i] for i in (start - 1, stop - 1) if 0 <= i < len(pace)]
        lingers = (stop - start - 1) * period > _LINGERS * sum(limit / max(a, 1e-300) for a in ends)
        if lingers and np.ptp(position[start:stop]) < nowhere:
            out[start:stop] = True
    return out


def stretches(which: np.ndarray) -> np.ndarray:
    """(R, 2) first sample and the one past the last of each stretch in which `which` (N,) is true."""
    return np.flatnonzero(np.diff(which.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)


def _rests_between(speed: np.ndarray, slow: float) -> np.ndarray:
    """(N,): whether the speed is below `slow` or changes its sign between a sample and the next."""
    out = np.append(speed[1:] * speed[:-1] <= 0, False)
    if len(speed) < 4:
        return out
    own = speed[1:-2]
    four = np.column_stack([speed[:-3], own, speed[2:-1], speed[3:]])
    between = four @ _cubic(_BETWEEN)
    out[1:-2] |= ((np.abs(between) < slow) | (between * own[:, None] <= 0)).any(axis=1)
    return out


def _cubic(t: np.ndarray) -> np.ndarray:
    """(4, T): Lagrange's weights of samples at -1, 0, 1, 2 for times t (T,)."""
    return np.array(
        [
            -t * (t - 1) * (t - 2) / 6,
            (t + 1) * (t - 1) * (t - 2) / 2,
            -(t + 1) * t * (t - 2) / 2,
            (t + 1) * t * (t - 1) / 6,
        ]
    )
