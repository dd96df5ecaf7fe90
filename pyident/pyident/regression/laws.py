"""The laws' columns of Φ over one motion, derived from the effects' own expressions."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, reduce

import numpy as np
import sympy

from flexmodels.coordinate import of_joint, signal_of, torque_of
from flexmodels.effects import signals
from flexmodels.effects.effect import Effect, State
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.regression import law_memory as law_states
from pyident.regression.loads.bodies import carried_loads
from pyident.regression.rounded_signs import blurred

_NUMPY = {
    "Max": lambda *values: reduce(np.maximum, values),
    "Min": lambda *values: reduce(np.minimum, values),
}
_WHOLE = slice(None)


@dataclass(frozen=True)
class LawColumn:
    """Column of `parameter` at coordinate `row`; value(part) is its (B,) piece of some samples."""

    parameter: str
    row: int
    value: Callable[[slice], np.ndarray]


def law_columns(
    robot: Robot, known: "Signals", k: int, effect: Effect, values: Mapping[str, float]
) -> list[LawColumn]:
    """Columns of a law at joint k, its nonlinear parameters at `values`. Raises ValueError."""
    return list(_Law(robot, known, k, effect, values).columns())


class Signals:
    """Every signal that a law may use, by its name behind `joint{k}.`; and `time`.

    Where the torque is held, `before` holds what a law sees until the sample and `after` from it on.
    `load` is that of the robot's own values: k[1] times eps[1], or what its links ask of a rigid joint.
    """

    def __init__(self, robot: Robot, motion: Motion):
        motion.check(robot)
        self.robot, self.motion = robot, motion
        self.rows = [coordinate.signal for coordinate in robot.q]
        self.size, self.held = len(motion.q), motion.tau_before is not None
        self.after = {} if motion.time is None else {"time": np.asarray(motion.time)}
        for j, coordinate in enumerate(robot.q):
            for order, rate in enumerate((motion.q, motion.dq, motion.ddq)):
                self.after[coordinate.rate(order)] = rate[:, j]
        for k, joint in robot.numbered:
            if joint.flexible:
                k1 = joint.values["stiffness"]["k[1]"]
                self.after[of_joint(k, "load")] = k1 * self.after[of_joint(k, "eps1")]
        torques = {"after": motion.tau, "before": motion.tau_before}
        named = {
            side: {} if tau is None else {torque_of(k): np.asarray(tau)[:, k - 1] for k, _ in robot.numbered}
            for side, tau in torques.items()
        }
        self.before = self.after | named["before"]
        self.after = self.after | named["after"]

    def of(self, place: str, before: bool = False) -> np.ndarray | None:
        """(N,) a signal, such as `joint2.de`; None where the motion does not have it."""
        known = self.before if before else self.after
        return known[place] if place in known else self._carried.get(place)

    @cached_property
    def _carried(self) -> dict[str, np.ndarray]:
        """The loads of the rigid joints: as many operations as Φ takes, and seldom asked for."""
        rigid = [k for k, joint in self.robot.numbered if not joint.flexible]
        torques = carried_loads(self.robot, self.motion) if rigid else None
        return {} if torques is None else {of_joint(k, "load"): torques[:, k - 1] for k in rigid}


class _Law:
    """One law at one joint over a motion."""

    def __init__(self, robot: Robot, known: Signals, k: int, effect: Effect, values: Mapping[str, float]):
        self.robot, self.known, self.k, self.effect = robot, known, k, effect
        self.own: dict[str, float | np.ndarray] = {
            p.name: self._fixed(values, p.name) for p in effect.nonlinear
        }
        for state in effect.states:
            self.own[state.name] = self._filtered(state)

    def columns(self) -> Iterator[LawColumn]:
        made: dict[sympy.Expr, Callable[[slice], np.ndarray]] = {}
        for parameter, slopes in self.effect.columns.items():
            for coordinate, slope in slopes.items():
                row = self.known.rows.index(signal_of(self.k, coordinate.name))
                if slope not in made:
                    made[slope] = self._piecewise(slope)
                yield LawColumn(parameter, row, made[slope])

    def _piecewise(self, law: sympy.Expr) -> Callable[[slice], np.ndarray]:
        """The law at some samples, the mean of both held torques' where it depends on them."""
        after = self._function(law)
        if not (self.known.held and _has_torque(law)):
            return after
        before = self._function(law, before=True)
        return lambda part: (after(part) + before(part)) / 2

    def _function(self, law: sympy.Expr, before: bool = False) -> Callable[[slice], np.ndarray]:
        names, value = compiled(blurred(law, self.robot.settings.processing.dead_zone))
        given = [self._signal(name, before) for name in names]
        return lambda part: value(*(x[part] if isinstance(x, np.ndarray) else x for x in given))

    def _signal(self, name: str, before: bool = False) -> float | np.ndarray:
        if name in self.own:
            return self.own[name]
        place = signal_of(self.k, name)
        values = self.known.of(place, before)
        if values is None:
            raise ValueError(
                f"effect {self.effect.name} at joint {self.k} needs the signal {place}, which the motion of "
                f"robot {self.robot.name} does not have; add the signal or remove the effect"
            )
        return values

    def _filtered(self, state: State) -> np.ndarray:
        """The state at the samples; under their hats where the torque is held."""
        h = np.diff(self._signal("time"))
        ends, first = [], []
        for law in state.coefficients:
            left = self._function(law)(_WHOLE) + np.zeros(self.known.size)
            right = left
            if self.known.held and _has_torque(law):
                right = self._function(law, before=True)(_WHOLE) + np.zeros(self.known.size)
            ends.append(np.array([left[:-1], right[1:]]))
            first.append(float(left[0]))
        a, b = ends[0].mean(axis=0), ends[1]
        start = law_states.equilibrium(*first) if state.start is None else state.start
        z = law_states.filtered(a, b, h, start)
        return law_states.hat_means(z, a, b, h) if self.known.held else z

    def _fixed(self, values: Mapping[str, float], name: str) -> float:
        if name not in values:
            raise ValueError(f"effect {self.effect.name} at joint {self.k} needs a value of its {name}")
        return float(values[name])


@cache
def _has_torque(law: sympy.Expr) -> bool:
    return signals.tau in law.free_symbols


@cache
def compiled(law: sympy.Expr) -> tuple[tuple[str, ...], Callable[..., np.ndarray]]:
    """The symbols of a law by name, and the law as a function of them, each (N,)."""
    symbols = sorted(law.free_symbols, key=str)
    return tuple(str(s) for s in symbols), sympy.lambdify(symbols, law, modules=[_NUMPY, "numpy"])
