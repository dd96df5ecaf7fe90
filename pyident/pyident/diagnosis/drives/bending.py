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

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyident.conditioning.standing import standing_in
from pyident.diagnosis.base.candidates import Candidate, described, drive
from pyident.diagnosis.base.projection import gains
from pyident.diagnosis.drives.springs import (
    DAMPING,
    Fit,
    Whitened,
    base_beside,
    fitted_beside,
    inertias_at,
    like_links,
    settled,
)
from pyident.diagnosis.search.found import Found, Step, candidates_of
from pyident.diagnosis.search.gate import region_of, share_in
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search
from pyident.regression.descriptions import DESCRIPTIONS, DRIVE
from pyident.regression.loads.swinging_drive import Spring, swung, up_to

_ROUNDS = 2
_LAST_ROUNDS = 6
_DRIVES = 4  # of a robot, that are fitted together
_SLOWEST, _PER_SWING, _FREQUENCIES = 1.0, 8, 20  # Hz; samples; to look at between
_RIVALS, _NEAR = 3, 0.5  # drives that are fitted, and the part of the most that their own equation tells


def about_bends(search: Search) -> Search | None:
    """The search at the parameters beside the drives that bend most; None where none does by much.

    The search must rest on nothing.
    """
    ex = search.examination
    if ex.setting.simulates:
        return None
    still = standing_in([log.part.motion for log in ex.logs], len(search.robot.joints))
    joints = [c.joint for c in described(search.robot, still) if c.effect == DRIVE]
    best, lacking = Fit(search.robot, {}, 0.0), float(search.lacking.sum())
    chance = float((search.rules.chance / ex.raised.max()) ** 2)  # energy that noise gives to a column
    while len(best.drives) < min(_DRIVES, len(joints)) and lacking - best.energy > chance:
        further = _further(search, best, [k for k in joints if k not in best.drives])
        own = search.lacking[[k - 1 for k in further.drives if k not in best.drives]].sum()
        least = search.rules.explained[0] * min(lacking - best.energy, own)
        if further.energy - best.energy <= max(chance, least):
            break
        best = further
    if not best.drives:
        return None
    best = max(best, settled(_whitened(search), best, _LAST_ROUNDS), key=lambda f: f.energy)
    best = _unless_much_more(search, best, [settled(_whitened(search), best.all_swinging, _LAST_ROUNDS)])
    return search.about(replace(ex.setting, robot=best.robot, bends=best.springs))


def _whitened(search: Search) -> Whitened:
    return Whitened(search.examination.logs, search.levels, search.base)


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


def _further(search: Search, fit: Fit, joints: Sequence[int]) -> Fit:
    """The fit with one more drive, that which takes most; on a swing if that takes much more than a sag."""
    sag = max((_with_sag(search, fit, k) for k in joints), key=lambda f: f.energy)
    scanned = sorted((_scanned(search, fit, k) for k in joints), key=lambda f: -f.energy)
    near = [f for f in scanned[:_RIVALS] if f.energy - fit.energy > _NEAR * (scanned[0].energy - fit.energy)]
    swings = [settled(_whitened(search), begun, _ROUNDS) for begun in (*near, sag.all_swinging)]
    return _unless_much_more(search, sag, swings)


def _unless_much_more(search: Search, sag: Fit, swings: Sequence[Fit]) -> Fit:
    """The fit in which links swing that takes most, if it takes much more than that in which they sag."""
    swing = max(swings, key=lambda f: f.energy)
    return swing if swing.energy > sag.energy + search.rules.part * search.lacking.sum() else sag


def _with_sag(search: Search, fit: Fit, joint: int) -> Fit:
    """The fit with a further drive's compliance, by its slope and, if that takes more, at the sag itself."""
    found = replace(fit, drives={**fit.drives, joint: None})
    for _ in range(_ROUNDS):
        found, compliance = fitted_beside(_whitened(search), found)
        if not 0 < compliance[joint] < DESCRIPTIONS[DRIVE].largest:
            return replace(fit, energy=0.0)
    sagging = replace(found, drives={**fit.drives, joint: Spring(compliance[joint], np.inf)})
    pairs = [(found, compliance), fitted_beside(_whitened(search), sagging)]
    best, told = max(pairs, key=lambda pair: pair[0].energy)
    return replace(best, drives={**fit.drives, joint: Spring(told[joint], np.inf)})


def _scanned(search: Search, fit: Fit, joint: int) -> Fit:
    """The fit with the spring that takes most beside its own in the joint's own equation."""
    logs, robot = search.examination.logs, fit.robot
    motion = logs[0].part.motion
    if motion.time is None or len(motion.q) <= 2:
        return replace(fit, energy=0.0)
    links, whole = inertias_at(robot, motion, joint)
    if whole <= 0:
        return replace(fit, energy=0.0)
    inertia = like_links(links, whole)
    step = float(np.median(np.diff(motion.time)))
    frequencies = np.geomspace(_SLOWEST, 1 / (_PER_SWING * step), _FREQUENCIES)
    compliances = 1 / (inertia * (2 * np.pi * frequencies) ** 2)
    springs = [Spring(float(c), z, links - inertia) for c in compliances for z in DAMPING]
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
    found = [g.energy for g in gains(base_beside(_whitened(search), fit), listed, [forward] * len(listed))]
    first = int(np.argmax(found))
    return replace(fit, drives={**fit.drives, joint: springs[first]}, energy=fit.energy + found[first])
