"""Values of an effect that a robot does not have yet: as large as is asked for, or small beside what acts."""

from collections.abc import Mapping

import numpy as np

from flexmodels.coordinate import of_joint
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.robot import Robot
from pyident.conditioning.samples import Conditioned
from pyident.regression.candidate_columns import effect_columns, nonlinear_grid

_SMALL = 0.05  # rms of an effect of unknown size, of the rms torque or moment on its row


def values_of(
    robot: Robot, law: Effect, joint: int, part: Conditioned, size: float | None = None
) -> dict[str, float]:
    """Of every parameter of a law at a joint (from 1), along a motion of the robot without it.

    size   of the parameter by which the law is sized; none: such that the law is small
    """
    grid = nonlinear_grid(robot, joint, law.name, [part.motion])
    found = dict(grid[len(grid) // 2])
    if not law.size.linear:
        found[law.size.name] = min(values[law.size.name] for values in grid)
    found |= {p.name: _small(robot, law, joint, part, p, found) for p in law.linear}
    return found if size is None else found | {law.size.name: size}


def _small(
    robot: Robot, law: Effect, joint: int, part: Conditioned, p: Parameter, nonlinear: Mapping[str, float]
) -> float:
    """A linear parameter's usual value, or one that makes its force small on the row where it is largest."""
    if p.usual is not None:
        own = {symbol: robot.parameters[of_joint(joint, str(symbol))] for symbol in p.usual.free_symbols}
        return float(p.usual.subs(own))
    columns = effect_columns(robot, joint, law.name, part.motion, nonlinear)
    row, force = max(columns[p.name].items(), key=lambda item: float(np.mean(item[1] ** 2)))
    stiffness, own = robot.q[row].stiffness, part.target[:, row]
    if stiffness is not None:
        own = robot.parameters[stiffness] * part.motion.q[:, row]
    rms = float(np.sqrt(np.mean(force**2)))
    natural = _SMALL * float(np.sqrt(np.mean(own**2))) / max(rms, 1e-300) / len(law.linear)
    return min(max(natural, p.lower), p.upper)
