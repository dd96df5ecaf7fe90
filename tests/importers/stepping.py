"""The loop of an importer that offers the bare calls of FMI: inputs, steps, Runge-Kutta, located events."""

from abc import ABC, abstractmethod

from request import Request

SUBSTEP = 0.5e-3  # of the integrator [s]
INSTANT = 1e-12  # to which a state event is located [s]


class BareFmu(ABC):
    """One initialised instance behind the same names for FMI 2 and FMI 3."""

    @abstractmethod
    def apply(self, i: int) -> None:
        """Set the inputs of communication point i."""

    @abstractmethod
    def outputs(self) -> list[float]: ...

    @abstractmethod
    def do_step(self, time: float, step: float) -> None: ...

    @abstractmethod
    def close(self) -> None: ...

    # ---- model exchange ----

    @abstractmethod
    def update_discrete_states(self) -> tuple[bool, float]:
        """Whether once more; the time of the next event."""

    @abstractmethod
    def enter_continuous_time_mode(self) -> None: ...

    @abstractmethod
    def enter_event_mode(self) -> None: ...

    @abstractmethod
    def at(self, time: float, x: list[float]) -> None: ...

    @abstractmethod
    def states(self) -> list[float]: ...

    @abstractmethod
    def rates(self) -> list[float]: ...

    @abstractmethod
    def indicators(self) -> list[float]: ...


def run(fmu: BareFmu, request: Request) -> list[list[float]]:
    """Outputs after each communication step."""
    loop = _model_exchange if request.interface == "ModelExchange" else _co_simulation
    rows = loop(fmu, request)
    fmu.close()
    return rows


def _co_simulation(fmu: BareFmu, request: Request) -> list[list[float]]:
    rows = []
    for i, t in enumerate(request.time[:-1]):
        fmu.apply(i)
        fmu.do_step(t, request.time[i + 1] - t)
        rows.append(fmu.outputs())
    return rows


def _model_exchange(fmu: BareFmu, request: Request) -> list[list[float]]:
    """A sample that is due at a communication point is a time event there."""
    rows = []
    _handle_event(fmu)
    for i, t in enumerate(request.time[1:]):
        _integrate(fmu, request.time[i], t)
        fmu.enter_event_mode()
        fmu.apply(i + 1)
        _handle_event(fmu)
        rows.append(fmu.outputs())
    return rows


def _handle_event(fmu: BareFmu) -> None:
    while fmu.update_discrete_states()[0]:
        pass
    fmu.enter_continuous_time_mode()


def _signs(fmu: BareFmu) -> list[bool]:
    return [z > 0 for z in fmu.indicators()]


def _advanced(fmu: BareFmu, t: float, x: list[float], h: float) -> list[float]:
    def rates_at(time: float, state: list[float]) -> list[float]:
        fmu.at(time, state)
        return fmu.rates()

    def moved(k: list[float], h: float) -> list[float]:
        return [a + h * b for a, b in zip(x, k, strict=True)]

    k1 = rates_at(t, x)
    k2 = rates_at(t + h / 2, moved(k1, h / 2))
    k3 = rates_at(t + h / 2, moved(k2, h / 2))
    k4 = rates_at(t + h, moved(k3, h))
    return moved([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)], h)


def _integrate(fmu: BareFmu, t: float, end: float) -> None:
    """Up to a communication point; state events on the way are located and handled."""
    x = fmu.states()
    while end - t > INSTANT:
        h = min(SUBSTEP, end - t)
        fmu.at(t, x)
        signs = _signs(fmu)
        after = _advanced(fmu, t, x, h)
        fmu.at(t + h, after)
        if _signs(fmu) == signs:
            t, x = t + h, after
            continue
        low = 0.0
        while h - low > INSTANT:
            middle = (low + h) / 2
            fmu.at(t + middle, _advanced(fmu, t, x, middle))
            low, h = (middle, h) if _signs(fmu) == signs else (low, middle)
        t, x = t + h, _advanced(fmu, t, x, h)
        fmu.at(t, x)
        fmu.enter_event_mode()
        _handle_event(fmu)
        x = fmu.states()
    fmu.at(end, x)
