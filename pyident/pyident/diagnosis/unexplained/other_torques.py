"""Whether what slow noise alone may excuse at a joint follows another joint's torque, as no noise does.

Currents and torque sensors of one joint show a part of another's. What that leaves at low frequencies looks
like the noise of amplifiers, which the logs do not show there. So the torques of all other joints are put to
the residual by a single coefficient: in the fitted logs, and in held-out ones, which must find the same one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pyident.diagnosis.base.projection import Base, extended, gain
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.measured import deviations
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.unexplained.smooth import whitened_columns
from pyident.regression.spectrum import Equations


@dataclass(frozen=True)
class _Size:
    """A coefficient with its standard deviation under coloured noise (White 1980)."""

    value: float
    std: float


def follow_other_torques(beside: Search, held: HeldOut, rows: Sequence[int]) -> set[int]:
    """Of some motor equations those; beside: rests on what was named. None without held-out logs."""
    if not held.equations or beside.examination.setting.simulates:
        return set()
    joints = range(len(beside.robot.joints))
    return {row for row in rows if any(_follows(beside, held, row, k) for k in joints if k != row)}


def _follows(beside: Search, held: HeldOut, row: int, joint: int) -> bool:
    """Whether an equation's residual does a joint's (from 0) torque, in size and in what that takes."""
    rules, ex = beside.rules, beside.examination
    X = _columns(ex.logs, beside.levels, row, joint)
    if not any(log[row].any() for log in X):
        return False
    left = beside.remaining_on([row])
    if left - ex.beyond_floor(extended(beside.base, X), [row]) < rules.explained[0] * left:
        return False
    fitted = _size(beside.base, X)
    if abs(fitted.value) < rules.chance * fitted.std:
        return False
    own = (
        _size(base, _columns([log], [ex.floor.at(log.band)], row, joint)) for log, base in held.beside(beside)
    )
    return all(_alike(fitted, unseen, rules.again) for unseen in own)


def _alike(fitted: _Size, unseen: _Size, again: float) -> bool:
    """Whether held-out logs show a coefficient, and the same one, within so many standard deviations."""
    apart = again * float(np.hypot(fitted.std, unseen.std))
    return abs(unseen.value) >= again * unseen.std and abs(unseen.value - fitted.value) <= apart


def _columns(
    logs: Sequence[Equations], levels: Sequence[np.ndarray], row: int, joint: int
) -> list[dict[int, np.ndarray]]:
    """Per log: row -> (E, 1)."""
    motions = [log.part.motion for log in logs]
    raw = [np.zeros((len(m.q), 1)) if m.tau is None else m.tau[:, [joint]] for m in motions]
    return [dict(log) for log in whitened_columns(raw, logs, levels, row)]


def _size(base: Base, X: Sequence[dict[int, np.ndarray]]) -> _Size:
    value = float(gain(base, X).coefficients[0])
    return _Size(value, abs(value) / max(deviations(base.residual, extended(base, X).residual), 1e-300))
