"""Columns that one more law would add to Φ, for a search over laws and over their nonlinear parameters."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product

import numpy as np
from sympy import Symbol

from flexmodels.coordinate import signal_of
from flexmodels.effects.effect import Effect, Parameter
from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression.laws import Signals, compiled, law_columns
from pyident.regression.loads.bodies import body_columns
from pyident.regression.recent import Recent
from pyident.regression.regressor import regressor_blocks

_PER_METRE = (1 / 3, 1.0, 3.0)  # of a lead: radians per metre are near no number of their own

_signals_of: Recent[Signals] = Recent(8)
_laws: Recent[tuple[Effect, dict[str, float]]] = Recent(256)


def effect_columns(
    robot: Robot, joint: int, effect_name: str, motion: Motion, values: Mapping[str, float] | None = None
) -> dict[str, dict[int, np.ndarray]]:
    """Parameter name -> row in `robot.coordinates` -> column (N,), of a law's linear parameters.

    joint    from 1; the robot need not have the effect
    values   of the nonlinear parameters; those left out are the robot's own or else the start values
    `load` is that of the robot's own stiffness and bodies, so a fitted robot should be given.
    Raises RobotError where the law cannot act, ValueError where a signal is missing.
    """
    law, fixed = _acting(robot, joint, effect_name, values or {})
    if law.body:
        return _of_body(robot, law, motion)
    columns: dict[str, dict[int, np.ndarray]] = {p.name: {} for p in law.linear}
    known: dict[Callable[[slice], np.ndarray], np.ndarray] = {}
    for column in law_columns(robot, _signals(robot, motion), joint, law, fixed):
        if column.value not in known:  # a force between two coordinates acts on both
            value = np.asarray(column.value(slice(None)), float)
            known[column.value] = np.array(np.broadcast_to(value, len(motion.q)))
        columns[column.parameter][column.row] = known[column.value]
    return columns


def nonlinear_grid(
    robot: Robot, joint: int, effect_name: str, motions: Sequence[Motion]
) -> list[dict[str, float]]:
    """The values that a search tries first: every combination of the grids, in the parameters' units.

    motions   of the logs, over all of which a signal's size or range is taken
    A law without nonlinear parameters has one, the empty one. Raises ValueError
    for a signal that the motion does not have, and as `effect_columns` does.
    """
    law, _ = _acting(robot, joint, effect_name, {})
    known = [_signals(robot, motion) for motion in motions]
    grids = []
    for p in law.nonlinear:
        if p.between is not None and counted_along_motion(robot, joint, p):
            size, size_of_next = (_size(_along(known, joint, signal)) for signal in p.between)
            lead = size / size_of_next if size_of_next > 0 else 1.0
            tried = [value * lead * factor for value in p.grid for factor in _PER_METRE]
        else:
            zero, one = _ends(known, joint, p)
            tried = [zero + value * (one - zero) for value in p.grid]
        grids.append([(p.name, min(max(value, p.lower), p.upper)) for value in tried])
    return [dict(values) for values in product(*grids)]


def counted_along_motion(robot: Robot, joint: int, p: Parameter) -> bool:
    """Whether a nonlinear parameter's grid is in units of the motion of a joint, from 1; else in its own."""
    if p.between is not None:
        return robot.joints[joint - 1].kind != robot.joints[joint].kind
    return p.scale is not None or p.across is not None


def _ends(known: Sequence[Signals], joint: int, p: Parameter) -> tuple[float, float]:
    """The values that the grid's 0 and 1 stand for, by the signal in which it is counted."""
    if p.across is not None:
        signal = _along(known, joint, p.across)
        return float(signal.min()), float(signal.max())
    return 0.0, 1.0 if p.scale is None else _size(_along(known, joint, p.scale))


def _size(signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def _along(known: Sequence[Signals], joint: int, symbol: Symbol) -> np.ndarray:
    """(N,) a signal of a joint in all logs, one after the other. Raises ValueError where one has none."""
    name = signal_of(joint, str(symbol))
    values = [x for signals in known if (x := signals.of(name)) is not None]
    if len(values) < len(known):
        raise ValueError(f"joint {joint} needs the signal {name}")
    return np.concatenate(values)


def coverage(
    robot: Robot, joint: int, effect_name: str, motion: Motion, values: Mapping[str, float] | None = None
) -> float | None:
    """How far the motion covers what the law needs: 1 is enough, 0 is nothing; None: it has no such rule."""
    law, fixed = _acting(robot, joint, effect_name, values or {})
    if law.coverage is None:
        return None
    names, holds = compiled(law.coverage.condition)
    known = _signals(robot, motion)
    given = [fixed[n] if n in fixed else known.of(signal_of(joint, n)) for n in names]
    return float(np.mean(holds(*given)) / law.coverage.share)


def _signals(robot: Robot, motion: Motion) -> Signals:
    return _signals_of.of((robot, motion), lambda: Signals(robot, motion))


def _acting(
    robot: Robot, joint: int, effect_name: str, values: Mapping[str, float]
) -> tuple[Effect, dict[str, float]]:
    """The law as it acts at the joint, and the values of its nonlinear parameters."""
    law, own = _laws.of((robot,), lambda: _law(robot, joint, effect_name), (joint, effect_name))
    unknown = set(values) - {p.name for p in law.nonlinear}
    if unknown:
        raise ValueError(f"effect {effect_name} has no nonlinear parameter {min(unknown)}")
    return law, {p.name: float(values.get(p.name, own[p.name])) for p in law.nonlinear}


def _law(robot: Robot, joint: int, effect_name: str) -> tuple[Effect, dict[str, float]]:
    """The law as it acts at the joint, and the values of its parameters there."""
    has = 1 <= joint <= len(robot.joints) and effect_name in robot.joints[joint - 1].values
    own = (robot if has else robot.with_effect(joint, effect_name)).joints[joint - 1]
    return own.law(effect_name), dict(own.values[effect_name])


def _of_body(robot: Robot, law: Effect, motion: Motion) -> dict[str, dict[int, np.ndarray]]:
    first = list(robot.linear_parameters).index(f"link{robot.last_link}.m")
    weights = body_columns(robot, law)
    W = np.column_stack(list(weights.values()))
    pieces = [
        Phi[:, :, first : first + len(LINK_PARAMETERS)] @ W for _, Phi in regressor_blocks(robot, motion)
    ]
    forces = np.concatenate(pieces).transpose(2, 1, 0)
    return {name: dict(enumerate(force)) for name, force in zip(weights, forces, strict=True)}
