"""fmuloader: the bare calls of FMI 2 and 3; the loop and the integrator are ours (Runge-Kutta, bisection)."""

from fmuloader.fmi2 import Fmi2Slave, Fmi2Type  # pyright: ignore[reportMissingImports]
from fmuloader.fmi3 import Fmi3Slave  # pyright: ignore[reportMissingImports]
from request import Description, Request, describe, read, write

SUBSTEP = 0.5e-3  # of the integrator [s]


class Fmu:
    """One instance behind the same names for FMI 2 and FMI 3."""

    def __init__(self, request: Request, description: Description):
        self.request, self.description = request, description
        old = description.version == "2.0"
        self.fmu = (Fmi2Slave if old else Fmi3Slave)(request.fmu, model_identifier=description.identifier)
        exchange = request.interface == "ModelExchange"
        if old:
            kind = Fmi2Type.MODEL_EXCHANGE if exchange else Fmi2Type.CO_SIMULATION
            self.fmu.instantiate("plant", kind, guid=description.token)
            self.fmu.setup_experiment(start_time=0.0)
            self.fmu.enter_initialization_mode()
            self.set, self.get = self.fmu.set_real, self.fmu.get_real
            self.rates = lambda: self.fmu.get_derivatives(description.states)
        else:
            make = self.fmu.instantiate_model_exchange if exchange else self.fmu.instantiate_co_simulation
            make("plant", instantiation_token=description.token)
            self.fmu.enter_initialization_mode(start_time=0.0)
            self.set, self.get = self.fmu.set_float64, self.fmu.get_float64
            self.rates = lambda: self.fmu.get_continuous_state_derivatives(description.states)
        self.old = old
        self.apply(0)
        self.fmu.exit_initialization_mode()

    def apply(self, i: int) -> None:
        inputs = self.request.inputs
        self.set(self.description.of(inputs), [values[i] for values in inputs.values()])

    def outputs(self) -> list[float]:
        return self.get(self.description.of(self.request.outputs))

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.free_instance()

    # ---- model exchange ----

    def handle_event(self) -> float:
        """From event mode to continuous time; the time of the next event."""
        while True:
            info = self.fmu.new_discrete_states() if self.old else self.fmu.update_discrete_states()
            if not (info.newDiscreteStatesNeeded if self.old else info.discrete_states_need_update):
                break
        self.fmu.enter_continuous_time_mode()
        return info.nextEventTime if self.old else info.next_event_time

    def at(self, time: float, x: list[float]) -> None:
        self.fmu.set_time(time)
        self.fmu.set_continuous_states(x)

    def rates_at(self, time: float, x: list[float]) -> list[float]:
        self.at(time, x)
        return self.rates()

    def signs(self) -> list[bool]:
        return [z > 0 for z in self.fmu.get_event_indicators(self.description.indicators)]

    def advanced(self, t: float, x: list[float], h: float) -> list[float]:
        def moved(k, h):
            return [a + h * b for a, b in zip(x, k, strict=True)]

        k1 = self.rates_at(t, x)
        k2 = self.rates_at(t + h / 2, moved(k1, h / 2))
        k3 = self.rates_at(t + h / 2, moved(k2, h / 2))
        k4 = self.rates_at(t + h, moved(k3, h))
        return moved([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)], h)

    def up_to(self, t: float, end: float) -> None:
        """Integrate to a time event; state events on the way are located and handled."""
        x = self.fmu.get_continuous_states(self.description.states)
        while end - t > 1e-12:
            h = min(SUBSTEP, end - t)
            self.at(t, x)
            signs = self.signs()
            after = self.advanced(t, x, h)
            self.at(t + h, after)
            if self.signs() == signs:
                t, x = t + h, after
                continue
            low = 0.0
            while h - low > 1e-12:
                middle = (low + h) / 2
                self.at(t + middle, self.advanced(t, x, middle))
                low, h = (middle, h) if self.signs() == signs else (low, middle)
            t, x = t + h, self.advanced(t, x, h)
            self.at(t, x)
            self.fmu.enter_event_mode()
            self.handle_event()
            x = self.fmu.get_continuous_states(self.description.states)
        self.at(end, x)


def co_simulation(fmu: Fmu, request: Request) -> list[list[float]]:
    rows = []
    for i, t in enumerate(request.time[:-1]):
        fmu.apply(i)
        fmu.fmu.do_step(t, request.time[i + 1] - t)
        rows.append(fmu.outputs())
    return rows


def model_exchange(fmu: Fmu, request: Request) -> list[list[float]]:
    rows = []
    event = fmu.handle_event()
    for i, t in enumerate(request.time[1:]):
        assert abs(event - t) < 1e-9, f"the next sample is at {event}, not at {t}"
        fmu.up_to(request.time[i], t)
        fmu.fmu.enter_event_mode()
        fmu.apply(i + 1)
        event = fmu.handle_event()
        rows.append(fmu.outputs())
    return rows


def main() -> None:
    request = read()
    fmu = Fmu(request, describe(request))
    run = model_exchange if request.interface == "ModelExchange" else co_simulation
    rows = run(fmu, request)
    fmu.close()
    write(dict(zip(request.outputs, map(list, zip(*rows, strict=True)), strict=True)))


main()
