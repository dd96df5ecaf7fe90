"""Values of an effect that a robot does not have yet: those that are known, or small beside what acts."""

from collections.abc import Mapping

import numpy as np

from flexmodels.coordinate import of_joint
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.regression.candidate_columns import effect_columns, nonlinear_grid

_SMALL = 0.05  # rms of an effect of unknown size, of the rms torque or moment on its row


def values_of(
    robot: Robot, law: Effect, joint: int, part: Conditioned, known: Mapping[str, float]
) -> dict[str, float]:
    """Of every parameter of a law at a joint (from 1), along a motion of the robot without it.

    known   parameter -> value; those that nobody knows are usual ones, or such that all together are small
    """
    grid = nonlinear_grid(robot, joint, law.name, [part.motion])
    found = dict(grid[len(grid) // 2])
    if not law.size.linear:
        found[law.size.name] = min(values[law.size.name] for values in grid)
    found |= {name: value for name, value in known.items() if name in found}
    columns = effect_columns(robot, joint, law.name, part.motion, found)
    free = [p for p in law.linear if p.name not in known and p.usual is None]
    found |= {p.name: _usual(robot, joint, p) for p in law.linear if p.usual is not None}
    found |= _small(robot, part, {p: columns[p.name] for p in free}) if free else {}
    return found | dict(known)


def _usual(robot: Robot, joint: int, p: Parameter) -> float:
    own = {symbol: robot.parameters[of_joint(joint, str(symbol))] for symbol in p.usual.free_symbols}
    return float(p.usual.subs(own))


def _small(
    robot: Robot, part: Conditioned, columns: Mapping[Parameter, Mapping[int, np.ndarray]]
) -> dict[str, float]:
    """Of linear parameters with these columns: as large as each other, and all together small."""
    each = {p: 1 / max(_share(robot, part, rows), 1e-300) for p, rows in columns.items()}
    total: dict[int, np.ndarray] = {}
    for p, rows in columns.items():
        for row, column in rows.items():
            total[row] = total.get(row, 0.0) + each[p] * column
    size = _SMALL / max(_share(robot, part, total), 1e-300)
    return {p.name: min(max(size * value, p.lower), p.upper) for p, value in each.items()}


def _share(robot: Robot, part: Conditioned, force: Mapping[int, np.ndarray]) -> float:
    """rms of a force (row -> (N,)) where it is largest, of the torque or moment that acts there."""
    row, values = max(force.items(), key=lambda item: float(np.mean(item[1] ** 2)))
    stiffness, own = robot.q[row].stiffness, part.target[:, row]
    if stiffness is not None:
        own = robot.parameters[stiffness] * part.motion.q[:, row]
    return float(np.sqrt(np.mean(values**2)) / max(np.sqrt(np.mean(own**2)), 1e-300))
