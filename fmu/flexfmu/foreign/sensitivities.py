"""Forward sensitivities of an FMU in model exchange, by its own directional derivatives.

With states x, parameters p, dx/dt = f and outputs y = g: the rows S = dx/dp obey dS/dt = ∂f/∂x S + ∂f/∂p and
give dy/dp = ∂g/∂x S + ∂g/∂p. The FMU gives each right-hand side along the direction (S, 1) by one call. That
holds as long as nothing jumps: an event, or an indicator that changes its sign, ends in a SimulationError.
"""

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmodels.inputs import SimulationError

_TOLERANCE = 1e-7  # of the integration; the slopes need not be better


@dataclass(frozen=True)
class Structure:
    """Value references of an FMU, and its number of event indicators.

    direction   those of the parameters, None for one that is the start of a state
    """

    states: tuple[int, ...]
    derivatives: tuple[int, ...]
    outputs: tuple[int, ...]
    direction: tuple[int | None, ...]
    indicators: int


@dataclass(frozen=True)
class Course:
    """Where the sensitivities are wanted: time (N,) [s], and the inputs' setter for an instant."""

    time: np.ndarray
    feed: Callable[[float], None]


def sensitivities(
    fmu: Any, structure: Structure, course: Course, start: np.ndarray, share: Callable[[float], None]
) -> np.ndarray:
    """(P, N, outputs): dy/dp along the course.

    fmu     in Continuous-Time Mode at the first instant
    start   (P, n) dx/dp at the first instant
    Raises SimulationError.
    """
    from scipy.integrate import solve_ivp

    equations = _Equations(fmu, structure, course)
    time, (P, n) = course.time, start.shape
    nominal = equations.nominal
    span = np.abs(start).max(axis=1, initial=0.0)
    scale = np.maximum(span, 1.0)[:, None] * nominal
    first = np.concatenate([equations.states()[None], start])

    def rate(t: float, flat: np.ndarray) -> np.ndarray:
        share(float((t - time[0]) / (time[-1] - time[0])))
        x, S = flat[:n], flat[n:].reshape(P, n)
        equations.at(t, x)
        return np.concatenate([equations.rate(), *(equations.along(j, s) for j, s in enumerate(S))])

    def jacobian(t: float, flat: np.ndarray) -> np.ndarray:
        """Without the curvature ∂²f/∂x² S, which an implicit step does not need (Maly and Petzold 1996)."""
        equations.at(t, flat[:n])
        return np.kron(np.eye(P + 1), equations.state_matrix())

    solution = solve_ivp(
        rate,
        (time[0], time[-1]),
        first.ravel(),
        method="LSODA",
        t_eval=time,
        rtol=_TOLERANCE,
        atol=_TOLERANCE * np.concatenate([nominal, scale.ravel()]),
        jac=jacobian,
    )
    if not solution.success or not np.isfinite(solution.y).all():
        raise SimulationError(f"the sensitivities could not be integrated ({solution.message})")
    rows = solution.y.T
    return equations.outputs_along(rows[:, :n], rows[:, n:].reshape(len(time), P, n))


class _Equations:
    """An FMU's right-hand sides and their directional derivatives."""

    def __init__(self, fmu: Any, structure: Structure, course: Course):
        self.fmu, self.structure, self.course = fmu, structure, course
        self._x, self._z = np.empty(len(structure.states)), np.empty(structure.indicators)
        self._px, self._pz = map(_pointer, (self._x, self._z))
        self._rate = getattr(fmu, "getContinuousStateDerivatives", None) or fmu.getDerivatives

    @property
    def nominal(self) -> np.ndarray:
        values = np.empty(len(self._x))
        self.fmu.getNominalsOfContinuousStates(_pointer(values), len(values))
        return np.where(values > 0, values, 1.0)

    def states(self) -> np.ndarray:
        self.fmu.getContinuousStates(self._px, len(self._x))
        return self._x.copy()

    def at(self, t: float, x: np.ndarray) -> None:
        self.fmu.setTime(t)
        self._x[:] = x
        self.fmu.setContinuousStates(self._px, len(self._x))
        self.course.feed(t)

    def rate(self) -> np.ndarray:
        values = np.empty(len(self._x))
        self._rate(_pointer(values), len(values))
        return values

    def along(self, parameter: int, s: np.ndarray) -> np.ndarray:
        """df/dp where dx/dp = s."""
        return self._along(self.structure.derivatives, parameter, s)

    def state_matrix(self) -> np.ndarray:
        """∂f/∂x."""
        states, rates = self.structure.states, self.structure.derivatives
        return np.column_stack(
            [self.fmu.getDirectionalDerivative(rates, states, row) for row in np.eye(len(states))]
        )

    def outputs_along(self, x: np.ndarray, S: np.ndarray) -> np.ndarray:
        """(P, N, outputs), while it is made sure that nothing jumps; x (N, n), S (N, P, n)."""
        states, outputs = self.structure.states, self.structure.outputs
        computed = [i for i, vr in enumerate(outputs) if vr not in states]
        rows = np.empty((S.shape[1], len(x), len(outputs)))
        for i, vr in enumerate(outputs):
            if vr in states:
                rows[:, :, i] = S[:, :, states.index(vr)].T
        signs: np.ndarray | None = None
        for k, t in enumerate(self.course.time):
            self.at(t, x[k])
            signs = self._same_side(t, signs)
            if computed:
                asked = [outputs[i] for i in computed]
                for j, s in enumerate(S[k]):
                    rows[j, k, computed] = self._along(asked, j, s)
            if self.fmu.completedIntegratorStep()[0]:
                raise SimulationError(f"the FMU has an event at {t:g} s")
        return rows

    def _along(self, unknowns: Sequence[int], parameter: int, s: np.ndarray) -> np.ndarray:
        itself = self.structure.direction[parameter]
        knowns = [*self.structure.states, *(() if itself is None else (itself,))]
        seed = [*s.tolist(), *(() if itself is None else (1.0,))]
        return np.array(self.fmu.getDirectionalDerivative(unknowns, knowns, seed))

    def _same_side(self, t: float, signs: np.ndarray | None) -> np.ndarray:
        if not len(self._z):
            return self._z
        self.fmu.getEventIndicators(self._pz, len(self._z))
        now = self._z > 0
        if signs is not None and (signs != now).any():
            raise SimulationError(f"the FMU has an event before {t:g} s")
        return now


def start_slopes(
    states_of: Callable[[Mapping[str, float]], np.ndarray],
    values: Mapping[str, float],
    steps: Mapping[str, float],
) -> np.ndarray:
    """(P, n): how the start of the states changes with the parameters, by central differences.

    states_of   states of the FMU when it was initialised with some values
    """
    rows = []
    for name, step in steps.items():
        ends = [states_of({**values, name: values[name] + side * step}) for side in (1, -1)]
        rows.append((ends[0] - ends[1]) / (2 * step))
    return np.array(rows)


def _pointer(values: np.ndarray):
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
