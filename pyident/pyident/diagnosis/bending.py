"""Drives that bend far: their columns where the robot's parameters are those beside them.

What a log lacks bends the parameters of a fit that does not know it, and columns of errors at these may have
little in common with the error: of a link that sagged by its drive, a column at bodies that had been fitted
without the sag took 7 % of what was missing, at bodies fitted beside it 91 %. So where something stands out
beside what is named, each drive's compliance is fitted together with the parameters, in rounds, at last with
the load that the link carries where it is (a slope is not enough for a large bend); then a further drive
beside it that takes much of the rest. What laws and errors come to there counts if it names a drive, and
leaves far less.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.standing import standing_in
from pyident.diagnosis.base.candidates import columns, described, drive
from pyident.diagnosis.base.projection import gain, joined, taken_over
from pyident.diagnosis.search.search import Search
from pyident.regression.descriptions import DESCRIPTIONS, DRIVE

_ROUNDS = 3
_DRIVES = 4  # of a robot, that are fitted together


@dataclass(frozen=True)
class _Fit:
    """A robot fitted with the compliances [rad/(N m)] of some joints' drives, and the energy these take."""

    robot: Robot
    bends: Mapping[int, float]
    energy: float


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
    while len(best.bends) < min(_DRIVES, len(joints)):
        tried = [_with(search, best, k) for k in joints if k not in best.bends]
        further = max(tried, key=lambda fit: fit.energy)
        taken, left = further.energy - best.energy, lacking - best.energy
        if taken < max(search.rules.part * lacking, search.rules.explained[0] * left):
            break
        best = further
    if not best.bends:
        return None
    return search.about(replace(ex.setting, robot=best.robot, bends=best.bends))


def _with(search: Search, fit: _Fit, joint: int) -> _Fit:
    """The fit with a further drive's compliance, by slopes and, if that takes more, at the bend itself."""
    found = replace(fit, bends={**fit.bends, joint: 0.0})
    for _ in range(_ROUNDS - 1):
        found = _round(search, found, dict.fromkeys(found.bends, 0.0) | dict(fit.bends))
    bent = _round(search, found, found.bends)
    return max(found, bent, key=lambda fit: fit.energy)


def _round(search: Search, fit: _Fit, about: Mapping[int, float]) -> _Fit:
    """Parameters and compliances fitted together, columns at those of a fit; about: bends they begin at."""
    ex = search.examination
    listed = [drive(k, c) for k, c in about.items()]
    X = joined([columns(fit.robot, c, ex.logs, search.levels) for c in listed])
    found = gain(search.base, X)
    p = search.base.p - taken_over(search.base, X) @ found.coefficients
    robot = fit.robot.with_parameters(dict(zip(fit.robot.linear_parameters, p.tolist(), strict=True)))
    bends = dict(zip(about, np.maximum(found.coefficients, 0.0).tolist(), strict=True))
    largest = DESCRIPTIONS[DRIVE].largest
    sound = all(0 < c < largest for c in bends.values())
    return _Fit(robot, bends, found.energy if sound else 0.0)
