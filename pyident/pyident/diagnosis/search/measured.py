"""Whether logs measure an error of the robot file that hardly exceeds their noise.

An axis that is turned by a fifth of a degree may explain a hundredth of a residual, and over thousands of
samples be certain all the same. Shares of the excess say nothing there; its value does: it is far from zero
in the fitted logs, and held-out logs, which move otherwise, find the same one. Either of the two must tell it
beyond any chance, the other surely. Standard deviations are those of coloured noise, from the residual at the
very frequencies where the error acts (White 1980), and no less than what replicas, which have no such error,
show of it: differences of held torques and of noisy angles make one by themselves, alike in every log. As
held-out logs ask for this one error alone, what replicas show of others is no chance that it shared.
It is asked for at the frequencies of the motion: beyond, a column holds what a low pass left of encoders'
noise, and the torque a controller's answer to it.
A torque that comes early by itself is not measured so: sensors and filters come late, and what hastens a
torque little by little is friction, or a brake.
Positions that had to be moved in time are where they belong to a fiftieth of a sample, which may be more than
such an error: it is measured beside a further move of all. Nothing is where they had to be sharpened.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyident.conditioning.alignment import Alignment
from pyident.diagnosis.base.candidates import Candidate, bounds
from pyident.diagnosis.base.projection import extended, gains_over, others_of
from pyident.diagnosis.misaligned import by_delay
from pyident.diagnosis.search.held_out import Unseen
from pyident.diagnosis.search.search import Search
from pyident.regression.descriptions import DESCRIPTIONS, DRIVE
from pyident.regression.loads.bodies import carried_loads
from pyident.simulation.denoised import denoises, where_moving

_LEAST_BEND = 1e-4  # rad: what no encoder behind a gear would show


def measured(search: Search, candidate: Candidate, unseen: Unseen | None) -> bool:
    """Whether the value of a candidate counts without a share of the excess: of errors of the robot file, and
    of laws that are their rivals.

    unseen   what it takes of held-out logs; none: it does not count
    """
    rules = search.rules
    setting = search.examination.setting
    alignment = setting.alignment
    sharpened = alignment != Alignment(alignment.late)
    if unseen is None or sharpened or search.stands_out or unseen.deviations < rules.again:
        return False
    if candidate.describes and not tells_errors(search):
        return False
    moving = where_moving(setting.robot, setting.logs, search.examination.logs)
    if alignment.needed:
        search = _beside_a_delay(search, moving)
    found = search.gain_of(candidate)
    value = found.coefficients
    if candidate.describes and not (worth_name(search, candidate, value) and can_be(candidate, value)):
        return False
    energies = _in_replicas(search, candidate)
    if np.mean(energies >= found.energy) >= rules.level:
        return False
    fitted = _deviations(search, candidate, moving) / max(np.sqrt(energies.mean()), 1.0)
    either = fitted >= rules.again and max(fitted, unseen.deviations) >= rules.chance
    return either and unseen.of_one_size(rules, 1 / fitted)


def tells_errors(search: Search) -> bool:
    """Whether an error of the robot file may show below the floor: only along a motion without its noise.

    An error's column is of the data's motion also where replicas are asked. The noise of that motion is in
    the data's residual as well, and looks like a gain below one; in the replicas' residual it is not.
    """
    return denoises(search.robot)


def _beside_a_delay(search: Search, moving: Sequence[np.ndarray]) -> Search:
    """The search that a further delay of all positions is no matter of."""
    return replace(search, base=extended(search.base, by_delay(search.examination, moving)))


def worth_name(search: Search, error: Candidate, value: np.ndarray) -> bool:
    """Whether an error of the robot file, its value (K,) in SI units, is large enough in the slowest log."""
    if error.effect == DRIVE and not _gives_way(search, error, value):
        return False
    return DESCRIPTIONS[error.effect].worth_name(value, search.examination.setting.period)


def _gives_way(search: Search, drive: Candidate, value: np.ndarray) -> bool:
    """Whether a hinge's drive of a compliance (1,) bends by what matters under its load."""
    if search.robot.joints[drive.joint - 1].kind != "revolute":
        return True
    motions = [log.part.motion for log in search.examination.logs]
    loads = np.concatenate([carried_loads(search.robot, motion)[:, drive.joint - 1] for motion in motions])
    return bool(value[0] * np.sqrt(np.mean(loads**2)) >= _LEAST_BEND)


def can_be(error: Candidate, value: np.ndarray) -> bool:
    """Whether a value (K,), in SI units, is not ahead of its time."""
    return not DESCRIPTIONS[error.effect].causal or bool(np.all(value > 0))


def _deviations(search: Search, candidate: Candidate, moving: Sequence[np.ndarray]) -> float:
    """Standard deviations of a coefficient from zero, where the motion is not noise alone."""
    beside = search.with_further([candidate]).base.residual
    clear = [[r[at] for r, at in zip(left, moving, strict=True)] for left in (search.base.residual, beside)]
    return deviations(*clear)


def deviations(before: Sequence[np.ndarray], after: Sequence[np.ndarray]) -> float:
    """Standard deviations from zero of a coefficient under coloured noise.

    before, after   what is left without and with it, per log (n, E) or any (E,) of these
    """
    fall, variance = 0.0, 0.0
    for without, beside in zip(before, after, strict=True):
        fall += float((np.square(without) - np.square(beside)).sum())
        variance += float((np.square(without - beside) * np.square(beside)).sum())
    return fall / max(float(np.sqrt(variance)), 1e-300)


def _in_replicas(search: Search, candidate: Candidate) -> np.ndarray:
    """(B,) what it takes of replicas: squares of standard deviations of white noise."""
    base, replicas = search.base, search.examination.replica_residuals
    ends = bounds(search.robot, candidate)
    return np.array(gains_over(base, search.columns(candidate), others_of(base, replicas), *ends))
