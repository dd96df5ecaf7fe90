"""Positions that all come late against the torques, or torques that all come through a low pass.

Another clock, a bus, drives that all lag: late by d the positions miss the torques by d times the rate of
these, at every joint, so that laws with a memory are found at several joints, and what is missing besides
drowns. The column is what moving the positions changes in the equations, the time the one that leaves least
of them. It has to take most of what exceeds the floor of two joints, and more than of any replica, to be
believed; or, of a sample or 5 ms, two joints at which nothing stands out have to measure about the same. It
is judged at the frequencies of the motion: a controller answers the noise of its encoder later than a robot.

A low pass of the torques (of a drive's current, or of a recorder) delays them likewise, and smears the steps
of dry friction, which then looks like presliding at every joint; so does one that went forwards and backwards
over the record, and delays nothing. Such low passes are tried beside the delay, by what is left at all
frequencies over a floor that went through them as well, and must leave clearly less. Presliding at every
joint in turn looks like a low pass. But what delays a torque does so at any time, so that it must not leave
more where no joint has just turned round.

Positions and torques of a robot whose loop is known belong together by its controller, and one joint alone
cannot be told from a law.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from pyident.conditioning.alignment import LATEST, NOTHING, Alignment, OwnWay
from pyident.conditioning.fading import fading
from pyident.conditioning.samples import Conditioned
from pyident.diagnosis.base.candidates import Candidate, columns_of
from pyident.diagnosis.base.projection import (
    Base,
    Columns,
    Gain,
    extended,
    gain,
    gains_over,
    others_of,
    residuals_of,
    solve_base,
)
from pyident.diagnosis.base.residual_over_floor import Examination, bands_of, whitened
from pyident.diagnosis.base.standing_out import standing_out
from pyident.diagnosis.moved_torques import energies_in, moved, typical
from pyident.regression.spectrum import Equations, Floor, all_over, equations, levels_of
from pyident.simulation.denoised import denoised_every_sample, where_moving

_ANY = (np.full(1, -np.inf), np.full(1, np.inf))
_STEP = 0.5  # samples
_JOINTS = 2  # that must tell the same
_EXACT = 0.02  # of a sample, and of the logarithm of a corner
_SMALL = 0.005  # s, or a sample: a drive's filter and a loop's hold, which may hide in the noise
_APART = 2.0  # times that the delay which leaves least may be of the one that is measured near none
_SAMPLES = 5.0  # more than these and `LATEST` is no matter of a clock
_SLOWEST = 0.1  # s that a low pass may delay
_HIGHEST = 0.8  # of the Nyquist frequency: corners above are none
_AFTER, _PART = 0.3, 0.3  # s after a reversal in which friction may grow; of the usual time to the next
# Whether any low pass is worth a search.
_TRIED = Alignment(poles=1), Alignment(poles=2), Alignment(poles=2, twice=True)
_SHAPES = (*(Alignment(poles=n) for n in (1, 2)), *(Alignment(poles=n, twice=True) for n in (2, 4)))
_CLEARLY = 0.95  # of what the best delay leaves, where a low pass is believed


def alignment_of(ex: Examination) -> Alignment:
    """What keeps positions and torques apart, if the logs tell."""
    setting = ex.setting
    joints = range(len(setting.robot.joints))
    if setting.simulates or len(joints) < _JOINTS:
        return NOTHING
    period = setting.period
    moving = where_moving(ex.setting.robot, ex.setting.logs, ex.logs)
    everywhere = [np.ones_like(clear) for clear in moving]
    delayed = by_delay(ex, moving)
    smeared = Alignment(corner=_HIGHEST * 0.5 / period, twice=True)
    if _shown(ex, delayed) is None and _shown(ex, _change(ex, smeared, everywhere)) is None:
        return NOTHING
    best = _best(ex, moving, period)
    data = _aligned(ex, best, ex.floors)
    base = solve_base(data)
    told = [k for k in joints if _tells(ex, base, data, k, moving)]
    small = best == best.delay and abs(best.late) <= max(period, _SMALL)
    if len(told) < _JOINTS and not (small and _measured_alike(ex, delayed, best.late)):
        return NOTHING
    return NOTHING if _belied(ex, best, moving) else best


def by_delay(ex: Examination, moving: Sequence[np.ndarray]) -> Columns:
    """What a small delay of all positions changes in the equations of all joints.

    moving   per log (n, E): where these move
    """
    period = ex.setting.period
    return _change(ex, Alignment(_STEP * period), moving)


def delay_beside(ex: Examination, named: Sequence[Candidate], told: bool = False) -> Alignment:
    """A small delay of all positions with which most joints leave less beside what was named, or all but one
    together, and none more.

    told   one torque was found late, by more than in any replica: that need not be asked of all together
    Torques that were put right by themselves go with the positions.
    """
    setting, own = ex.setting, sorted(way.joint for way in ex.setting.alignment.own)
    rows = [k - 1 for k, _ in setting.robot.numbered if k not in own]
    put_right = replace(setting.alignment, own=()).needed
    if setting.simulates or len(rows) < _JOINTS or put_right:
        return NOTHING
    period, chance = setting.period, setting.rules.search.chance**2
    moving = where_moving(setting.robot, setting.logs, ex.logs)
    base = _beside(ex, named)
    delayed = [{k: X for k, X in log.items() if k in rows} for log in by_delay(ex, moving)]
    if not told and _shown(replace(ex, base=base), delayed, chance) is None:
        return NOTHING

    def energies(late: float) -> np.ndarray:
        return energies_in(moved(ex.logs, ex.levels, base, late), moving)[rows]

    count, furthest = np.sum([clear[rows].sum(axis=1) for clear in moving], axis=0), max(period, _SMALL)
    left = _least(
        lambda late: count @ np.log(np.maximum(energies(late), 1e-300)),
        (-furthest, furthest),
        _EXACT * period,
    )
    fall = energies(0.0) - energies(left.x)
    several = (fall > chance).sum() >= max(_JOINTS, len(rows) / 2)
    others = fall.sum() - fall.max() > chance
    if not (several or others) or (fall < -chance).any():
        return NOTHING
    return Alignment(float(left.x), own=tuple(OwnWay(k, float(left.x)) for k in own))


def _beside(ex: Examination, named: Sequence[Candidate]) -> Base:
    """The examination's base with the columns of what was named."""
    base = ex.base
    for X in columns_of(ex.setting.robot, named, ex.logs, ex.levels):
        base = extended(base, X)
    return base


def _measured_alike(ex: Examination, delayed: Columns, late: float) -> bool:
    """Whether two joints where nothing stands out measure about the same delay, in their noise or above it,
    and together what leaves least.

    delayed   as of `_change`, by a delay of a step;  late: what leaves least [s]
    """
    rules, out = ex.setting.rules.search, standing_out(ex, ex.base)
    quiet = [k for k in range(len(ex.setting.robot.joints)) if not out[k]]
    if len(quiet) < _JOINTS:
        return False
    of_quiet = [{k: X for k, X in log.items() if k in quiet} for log in delayed]
    together, alike = float(gain(ex.base, of_quiet).coefficients[0]), 0
    measured = -together * _STEP * ex.setting.period
    if not 1 / _APART <= late / (measured or np.inf) <= _APART:
        return False
    for k in quiet:
        found = _shown(ex, [{k: log[k]} for log in delayed], rules.chance**2)
        alike += found is not None and abs(found.coefficients[0] / together - 1) <= 1 - rules.unseen
    return alike >= _JOINTS


def _best(ex: Examination, moving: Sequence[np.ndarray], period: float) -> Alignment:
    """The delay that leaves least, or the low pass that leaves clearly less, by itself or with a delay.

    Positions may be late or early: at reversals, which a low pass smears, the column may have the wrong sign.
    """
    furthest, exact = max(_SAMPLES * period, LATEST), _EXACT * period
    low, high = np.log([1 / (2 * np.pi * _SLOWEST), _HIGHEST * 0.5 / period]).tolist()
    delay = Alignment(_delay(ex, moving, furthest, exact))
    tried = [
        replace(shape, corner=float(np.exp(x))) for shape in _TRIED for x in np.linspace(low, high, 5)[1:-1]
    ]
    clearly = _CLEARLY * _left_behind(ex, delay)
    if all(_left_behind(ex, low_pass) >= clearly for low_pass in tried):
        return delay
    passes = [_with_corner(ex, shape, (low, high)) for shape in _SHAPES]
    alone, least = min(passes, key=lambda found: found[1])
    late = _least(lambda t: _left_behind(ex, replace(alone, late=t)), (-furthest, furthest), exact).x
    both, rest = _with_corner(ex, replace(alone, late=late), (low, high))
    if rest < _CLEARLY * least:
        return both
    return alone if least < clearly else delay


def _delay(ex: Examination, moving: Sequence[np.ndarray], furthest: float, exact: float) -> float:
    """The time [s] by which positions come late that leaves least.

    What is left out at bends of the torques is where the positions belong once a first time is known.
    """

    def left(data: Sequence[Equations], levels: Sequence[np.ndarray], base: Base, late: float) -> float:
        return typical(moved(data, levels, base, late), moving)

    given = partial(left, ex.logs, ex.levels, ex.base)
    found = min(
        (_least(given, ends, exact) for ends in ((-furthest, 0.0), (0.0, furthest))), key=lambda d: d.fun
    )
    data, period = _aligned(ex, Alignment(found.x), ex.floors), ex.setting.period
    again = partial(left, data, levels_of(ex.floors, data), solve_base(data))
    return float(found.x + _least(again, (-period, period), exact).x)


def _least(left: Callable[[float], float], bounds: tuple[float, float], exact: float) -> Any:
    return minimize_scalar(left, bounds=bounds, options={"xatol": exact})  # pyright: ignore


def _with_corner(ex: Examination, shape: Alignment, ends: tuple[float, float]) -> tuple[Alignment, float]:
    """The low pass of a shape that leaves least, and what it leaves; ends: of the logarithm of its corner."""

    def low_pass(logarithm: float) -> Alignment:
        return replace(shape, corner=float(np.exp(logarithm)))

    found = _least(lambda x: _left_behind(ex, low_pass(x)), ends, _EXACT)
    return low_pass(found.x), float(found.fun)


def _left_behind(ex: Examination, alignment: Alignment) -> float:
    """What is left of all equations on average, over a floor as of noise that did not pass the low pass."""
    floors = [Floor(f.frequencies, f.rms / np.abs(alignment.passed(f.frequencies))) for f in ex.floors]
    data = _aligned(ex, alignment, floors)
    return _left(data, [np.ones(e.y.shape, bool) for e in data])


def _aligned(ex: Examination, alignment: Alignment, floors: Sequence[Floor]) -> list[Equations]:
    robot = ex.setting.robot
    return whitened(robot, alignment.of_all(robot, ex.setting.logs), floors)


def _left(data: Sequence[Equations], asked: Sequence[np.ndarray]) -> float:
    """What is left of an equation on average, over its floor; asked: per log (n, E)."""
    return typical(residuals_of(data), asked)


def _shown(ex: Examination, X: Columns, least: float = 0.0) -> Gain | None:
    """What columns explain, if that is more than of any replica, and than a least energy."""
    found = gain(ex.base, X)
    of_replicas = gains_over(ex.base, X, others_of(ex.base, ex.replica_residuals), *_ANY)
    return found if found.energy > max(least, *of_replicas) else None


def _change(ex: Examination, step: Alignment, asked: Sequence[np.ndarray]) -> Columns:
    """What a small step changes in the equations of all joints, where they are asked; per log (n, E)."""
    X: Columns = []
    for there, here, clear in zip(_aligned(ex, step, ex.floors), ex.logs, asked, strict=True):
        change = ((there.y - there.A @ ex.base.p) - (here.y - here.A @ ex.base.p)) * clear
        X.append({k: change[k][:, None] for k in range(len(ex.setting.robot.joints))})
    return X


def _tells(
    ex: Examination, base: Base, data: Sequence[Equations], k: int, moving: Sequence[np.ndarray]
) -> bool:
    """Whether joint k (from 0) lacks far less once the positions are where they belong."""
    rules, count = ex.setting.rules.search, sum(int(clear[k].sum()) for clear in moving)
    before, floor = ex.excess(ex.base.residual, _bands(ex.logs, k, moving), [k])
    after, _ = ex.excess(base.residual, _bands(data, k, moving), [k])
    chance = rules.chance * np.sqrt(2 * count)  # of the energy of noise, by its own floor
    return before - after > chance * floor / count and after < (1 - rules.explained[0]) * before


def _belied(ex: Examination, found: Alignment, moving: Sequence[np.ndarray]) -> bool:
    """Whether its delay leaves more, beyond chance, at more joints than it leaves less, where those have not
    just turned round."""
    robot, joints = ex.setting.robot, len(ex.setting.robot.joints)
    left = []
    for alignment in (NOTHING, found.delay):
        logs = alignment.of_all(robot, ex.setting.logs)
        parts = [_between_reversals(denoised_every_sample(robot, log), log.period) for log in logs]
        data = equations(robot, parts, [log.period for log in logs])
        pairs = zip(residuals_of(all_over(data, levels_of(ex.floors, data))), moving, strict=True)
        left.append(sum((np.square(r) * clear).sum(axis=1)[:joints] for r, clear in pairs))
    before, after = left
    chance = 1 + ex.setting.rules.search.chance * np.sqrt(
        2 / sum(clear[:joints].sum(axis=1) for clear in moving)
    )
    return int((after > chance * before).sum()) > int((before > chance * after).sum())


def _between_reversals(part: Conditioned, period: float) -> Conditioned:
    """Without what follows a joint's reversal, and a little before it."""
    use = part.use.copy()
    for k, speed in enumerate(part.motion.dq.T):
        turns = np.flatnonzero(np.diff(np.sign(speed)))
        after = round(min(_AFTER / period, _PART * len(speed) / (1 + len(turns))))
        for turn in turns:
            use[max(turn - after // 4, 0) : turn + after, k] = 0.0
    return replace(part, use=fading(use))


def _bands(logs: Sequence[Equations], k: int, moving: Sequence[np.ndarray]) -> list[np.ndarray]:
    """As `bands_of`, of what row k has in motion."""
    return [inside * clear[k][:, None] for inside, clear in zip(bands_of(logs), moving, strict=True)]
