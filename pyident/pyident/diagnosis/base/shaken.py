"""What a wave at one joint does in the equations of the others.

A ripple shakes its joint, and by way of the links' inertia the others, at frequencies that a motion without
its noise has lost. So it stands in their equations as well, where it is no effect of theirs. There it has a
size and phase at every speed, as the wave itself has that shows an arm to shake.
"""

from functools import partial

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.diagnosis.base.candidates import Candidate, torques_per_unit
from pyident.diagnosis.base.projection import Base, Columns, extended, gain
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.regression.recent import Recent
from pyident.regression.spectrum import Band

_waves: Recent[dict[int, np.ndarray]] = Recent(16)


def with_shaken(ex: Examination, candidate: Candidate, base: Base) -> Base:
    """A base with columns of a wave in the equations of other joints, where they take more than noise gives.

    base   with the wave's own
    """
    if not candidate.speeds:
        return base
    robot, chance = ex.setting.robot, ex.setting.rules.search.chance
    each = [
        _waves.of((robot, log.part), partial(_in_all, robot, candidate, log.part, log.band), candidate)
        for log in ex.logs
    ]
    for row in each[0]:
        X: Columns = [
            {row: own[row] / level[row][:, None]} for own, level in zip(each, ex.levels, strict=True)
        ]
        count = X[0][row].shape[1]
        if gain(base, X).energy > count + chance * np.sqrt(2 * count):
            base = extended(base, X)
    return base


def _in_all(robot: Robot, candidate: Candidate, part: Conditioned, band: Band) -> dict[int, np.ndarray]:
    """Row -> (E, K): the wave as it would be used in the equation of every joint on which it does not act."""
    acting = torques_per_unit(robot, candidate, part)
    others = [row for row in range(len(robot.joints)) if row not in acting]
    wave = next(iter(acting.values()))
    return {row: band.transform(part.used(row, wave).T) for row in others}
