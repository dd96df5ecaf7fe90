"""Drives that bend far, or on which links swing: their columns at parameters that are those beside them.

What a log lacks bends the parameters of a fit that does not know it, and columns of errors at these may have
little in common with the error: of a link that sagged by its drive, a column at bodies that had been fitted
without the sag took 7 % of what was missing, at bodies fitted beside it 91 %. So where something stands out
beside what is named, each drive's compliance is fitted together with the parameters, in rounds. A slope knows
no resonance, so of those that take most the springs are sought on which links swing as the log shows; then a
further drive beside it that takes much of the rest. What laws and errors come to there counts if it names a
drive, and leaves far less.

Drives whose links swing belong together: the motor of one feels the other's. So they are named together,
where they take most of what is missing at each, and held-out logs show them far beyond chance. Their size
there may be less: noise of the motors' motion, which a resonance enlarges, lessens whatever is fitted to it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from flexmodels.robot import Robot
from pyident.conditioning.standing import standing_in
from pyident.diagnosis.base.candidates import Candidate, columns, described, drive
from pyident.diagnosis.base.projection import Base, Columns, extended, gain, gains, joined, taken_over
from pyident.diagnosis.search.found import Found, Step, candidates_of
from pyident.diagnosis.search.gate import region_of, share_in
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search
from pyident.regression.descriptions import DESCRIPTIONS, DRIVE
from pyident.regression.loads.swinging_drive import Spring, Springs, carries, swung, typical_inertia, up_to

_ROUNDS = 2
_LAST_ROUNDS = 6
_DRIVES = 4  # of a robot, that are fitted together
_SLOWEST, _PER_SWING, _FREQUENCIES = 1.0, 8, 20  # Hz; samples; to look at between
_DAMPING = (0.02, 0.1)  # ratios
_LOOKS = 6  # steps towards other springs
_WITHIN, _STEP = 1.5, 1e-3  # of logarithms of compliances and dampings
_LINKS = 0.9  # of an inertia that a motor may have of it, at most
_RIVALS, _NEAR = 3, 0.5  # drives that are fitted, and the part of the most that their own equation tells
_RESTS = 0.02  # of a compliance
_ALIKE = 4.0  # times: so far may the size of a swing be from that of the spring that makes it


@dataclass(frozen=True)
class _Fit:
    """A robot fitted with springs of drives, none: with the slope of that, and the energy that these take."""

    robot: Robot
    drives: Mapping[int, Spring | None]
    energy: float

    @property
    def springs(self) -> Springs:
        return {k: spring for k, spring in self.drives.items() if spring is not None}

    @property
    def all_swinging(self) -> "_Fit":
        """The same, with a damping for links that only sag."""
        damped = {k: s if s.swings else replace(s, damping=_DAMPING[-1]) for k, s in self.springs.items()}
        return replace(self, drives={**self.drives, **damped})

    @property
    def swings(self) -> Springs:
        return {k: spring for k, spring in self.springs.items() if spring.swings}


def about_bends(search: Search) -> Search | None:
    """The search at the parameters beside the drives that bend most; None where none does by much.

    The search must rest on nothing.
    """
    ex = search.examination
    if ex.setting.simulates:
        return None
    still = standing_in([log.part.motion for log in ex.logs], len(search.robot.joints))
    joints = [c.joint for c in described(search.robot, still) if c.effect == DRIVE]
    best, lacking = _Fit(search.robot, {}, 0.0), float(search.lacking.sum())
    chance = float((search.rules.chance / ex.raised.max()) ** 2)  # energy that noise gives to a column
    while len(best.drives) < min(_DRIVES, len(joints)) and lacking - best.energy > chance:
        further = _further(search, best, [k for k in joints if k not in best.drives])
        (joint,) = further.drives.keys() - best.drives
        left = min(lacking - best.energy, search.lacking[joint - 1])
        if further.energy - best.energy < max(chance, search.rules.explained[0] * left):
            break
        best = further
    if not best.drives:
        return None
    best = max(best, _settled(search, best, _LAST_ROUNDS), key=lambda f: f.energy)
    best = _unless_much_more(search, best, [_settled(search, best.all_swinging, _LAST_ROUNDS)])
    return search.about(replace(ex.setting, robot=best.robot, bends=best.springs))


def links_swing(search: Search, in_time: Search) -> bool:
    """Whether positions seem late as drives bend: swinging links leave far less than logs put in time."""
    in_time, search = in_time.resting_on(()), search.resting_on(())
    bent = about_bends(search) if in_time.stands_out else None
    drives = candidates_of(swinging(bent, HeldOut(()))) if bent else []
    if not bent or not drives:
        return False
    left = bent.resting_on(drives).lacking.sum()
    return bool(left <= (1 - search.rules.explained[0]) * in_time.lacking.sum())


def swinging(bent: Search, held: HeldOut) -> list[Step]:
    """The drives, as steps of a selection, on whose springs links swing; none where logs do not bear all out.

    bent   of `about_bends`
    """
    springs = bent.examination.setting.bends
    drives = [drive(k, up_to(springs, k)) for k, spring in springs.items() if spring.swings]
    if not drives or not all(_borne_out(bent, c, drives, held) for c in drives):
        return []
    steps = []
    for c in drives:
        view = bent.resting_on([other for other in drives if other is not c])
        found = Found(c, view.gain_of(c), 0.0, 1.0)
        steps.append(Step((found,), bent.p_value(found), ()))
    return steps


def _borne_out(bent: Search, lead: Candidate, drives: Sequence[Candidate], held: HeldOut) -> bool:
    """Whether drives take most of what is missing where one acts, of about its spring's size, and held-out
    logs show them.
    """
    rules, region = bent.rules, region_of(bent, lead)
    springs = bent.examination.setting.bends
    sizes = bent.fitted(drives)[1] / [springs[c.joint].compliance for c in drives]
    if not all(rules.unseen <= size <= 1 / rules.unseen for size in sizes):
        return False
    if share_in(bent, drives, region) < rules.explained[-1]:
        return False
    unseen = held.share(bent, drives, region)
    if unseen is None:
        return True
    return unseen.deviations >= rules.chance and rules.unseen <= unseen.size <= 1 / rules.unseen


def _further(search: Search, fit: _Fit, joints: Sequence[int]) -> _Fit:
    """The fit with one more drive, that which takes most; on a swing if that takes much more than a sag."""
    sag = max((_with_sag(search, fit, k) for k in joints), key=lambda f: f.energy)
    scanned = sorted((_scanned(search, fit, k) for k in joints), key=lambda f: -f.energy)
    near = [f for f in scanned[:_RIVALS] if f.energy - fit.energy > _NEAR * (scanned[0].energy - fit.energy)]
    swings = [_settled(search, begun, _ROUNDS) for begun in (*near, sag.all_swinging)]
    return _unless_much_more(search, sag, swings)


def _unless_much_more(search: Search, sag: _Fit, swings: Sequence[_Fit]) -> _Fit:
    """The fit in which links swing that takes most, if it takes much more than that in which they sag."""
    swing = max(swings, key=lambda f: f.energy)
    return swing if swing.energy > sag.energy + search.rules.part * search.lacking.sum() else sag


def _with_sag(search: Search, fit: _Fit, joint: int) -> _Fit:
    """The fit with a further drive's compliance, by its slope and, if that takes more, at the sag itself."""
    found = replace(fit, drives={**fit.drives, joint: None})
    for _ in range(_ROUNDS):
        found, compliance = _fitted(search, found)
        if not 0 < compliance[joint] < DESCRIPTIONS[DRIVE].largest:
            return replace(fit, energy=0.0)
    sagging = replace(found, drives={**fit.drives, joint: Spring(compliance[joint], np.inf)})
    pairs = [(found, compliance), _fitted(search, sagging)]
    best, told = max(pairs, key=lambda pair: pair[0].energy)
    return replace(best, drives={**fit.drives, joint: Spring(told[joint], np.inf)})


def _settled(search: Search, fit: _Fit, rounds: int) -> _Fit:
    """The fit with its springs sought anew from those it has, in rounds with the parameters."""
    found = best = replace(fit, energy=0.0)
    for _ in range(rounds if fit.swings else 0):
        before = found.swings
        found, compliances = _fitted(search, _sought(search, found))
        sizes = [compliances[k] / spring.compliance for k, spring in found.swings.items()]
        if all(1 < _ALIKE * size < _ALIKE**2 for size in sizes) and found.energy > best.energy:
            best = found
        moved = [abs(np.log(s.compliance / before[k].compliance)) for k, s in found.swings.items()]
        if max(moved) < _RESTS:
            break
    return best


def _scanned(search: Search, fit: _Fit, joint: int) -> _Fit:
    """The fit with the spring that takes most beside its own in the joint's own equation."""
    logs, robot = search.examination.logs, fit.robot
    motions = [log.part.motion for log in logs]
    if not all(carries(robot, motion, joint) for motion in motions):
        return replace(fit, energy=0.0)
    inertia = typical_inertia(robot, motions[0], joint)
    step = float(np.median(np.diff(np.asarray(motions[0].time))))
    frequencies = np.geomspace(_SLOWEST, 1 / (_PER_SWING * step), _FREQUENCIES)
    springs = [Spring(1 / (inertia * (2 * np.pi * f) ** 2), z) for f in frequencies for z in _DAMPING]
    own: list[np.ndarray] = []
    for log, level in zip(logs, search.levels, strict=True):
        before = swung(robot, log.part.motion, fit.swings)[joint - 1] if fit.swings else 0.0
        changes = [
            swung(robot, log.part.motion, {**fit.swings, joint: spring})[joint - 1] - before
            for spring in springs
        ]
        X = log.band.transform(log.part.used(joint - 1, np.array(changes)).T)
        own.append(X / level[joint - 1][:, None])
    listed = [[{joint - 1: X[:, [i]]} for X in own] for i in range(len(springs))]
    forward = (np.zeros(1), np.full(1, np.inf))
    found = [g.energy for g in gains(_beside(search, fit), listed, [forward] * len(listed))]
    first = int(np.argmax(found))
    return replace(fit, drives={**fit.drives, joint: springs[first]}, energy=fit.energy + found[first])


def _sought(search: Search, fit: _Fit) -> _Fit:
    """The fit with springs about its own that leave least of all equations, beside drives that only sag.

    Of the inertia that follows a motor, how much is its own is sought as well: it decides how links swing.
    """
    springs = fit.swings
    if any(spring.compliance <= 0 or spring.damping <= 0 for spring in springs.values()):
        return fit  # a spring that pushes is none
    logs = search.examination.logs
    base = _beside(search, replace(fit, drives={k: s for k, s in fit.drives.items() if k not in springs}))
    inertias = [typical_inertia(fit.robot, logs[0].part.motion, k) for k in springs]

    def at(x: np.ndarray) -> Springs:
        rows = zip(springs, inertias, x.reshape(-1, 3).tolist(), strict=True)
        return {k: Spring(math.exp(c), math.exp(z), share * J) for k, J, (c, z, share) in rows}

    def left(x: np.ndarray) -> np.ndarray:
        changed = _changed(search, fit.robot, at(x))
        imitated = sum(np.tensordot(c, own, 2) for c, own in zip(changed, base.basis, strict=True))
        each = zip(base.residual, changed, base.basis, strict=True)
        return np.concatenate([(r - c + own @ imitated).ravel() for r, c, own in each])

    told = zip(springs.values(), inertias, strict=True)
    start = np.array([(math.log(s.compliance), math.log(s.damping), s.rotor / J) for s, J in told])
    lowest = start - [_WITHIN, _WITHIN, np.inf]
    highest = np.column_stack([start[:, :2] + _WITHIN, np.maximum(start[:, 2], _LINKS) + _RESTS])
    ends = lowest.ravel(), highest.ravel()
    found = least_squares(left, start.ravel(), bounds=ends, diff_step=_STEP, max_nfev=_LOOKS)
    return replace(fit, drives={**fit.drives, **at(found.x)})


def _changed(search: Search, robot: Robot, springs: Springs) -> list[np.ndarray]:
    """Per log (n, E): what links that swing change in the equations."""
    out = []
    for log, level in zip(search.examination.logs, search.levels, strict=True):
        change = swung(robot, log.part.motion, springs)
        used = np.array([log.part.used(row, own) for row, own in enumerate(change)])
        out.append(log.band.transform(used.T).T / level)
    return out


def _beside(search: Search, fit: _Fit) -> Base:
    """The base with the drives of a fit."""
    return extended(search.base, joined(_columns(search, fit))) if fit.drives else search.base


def _columns(search: Search, fit: _Fit) -> list[Columns]:
    """Of each drive of a fit."""
    listed = [drive(k, up_to(fit.springs, k)) for k in fit.drives]
    return [columns(fit.robot, c, search.examination.logs, search.levels) for c in listed]


def _fitted(search: Search, fit: _Fit) -> tuple[_Fit, dict[int, float]]:
    """The fit with parameters fitted together with its drives, columns at those before; and compliances."""
    X = joined(_columns(search, fit))
    found = gain(search.base, X)
    p = search.base.p - taken_over(search.base, X) @ found.coefficients
    robot = fit.robot.with_parameters(dict(zip(fit.robot.linear_parameters, p.tolist(), strict=True)))
    told = dict(zip(fit.drives, found.coefficients.tolist(), strict=True))
    return replace(fit, robot=robot, energy=found.energy), told
