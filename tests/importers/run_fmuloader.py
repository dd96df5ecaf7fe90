"""fmuloader: the bare calls of FMI 2 and 3; the loop and the integrator are those of `stepping`."""

from fmuloader.fmi2 import Fmi2Slave, Fmi2Type  # pyright: ignore[reportMissingImports]
from fmuloader.fmi3 import Fmi3Slave  # pyright: ignore[reportMissingImports]
from request import Description, Request, describe, read, write
from stepping import BareFmu, run


class Fmu(BareFmu):
    def __init__(self, request: Request, description: Description):
        self.request, self.description = request, description
        self.old = old = description.version == "2.0"
        self.fmu = (Fmi2Slave if old else Fmi3Slave)(request.fmu, model_identifier=description.identifier)
        exchange = request.interface == "ModelExchange"
        if old:
            kind = Fmi2Type.MODEL_EXCHANGE if exchange else Fmi2Type.CO_SIMULATION
            self.fmu.instantiate("plant", kind, guid=description.token)
            self.fmu.setup_experiment(start_time=0.0)
            self.fmu.enter_initialization_mode()
            self.set, self.get = self.fmu.set_real, self.fmu.get_real
        else:
            make = self.fmu.instantiate_model_exchange if exchange else self.fmu.instantiate_co_simulation
            make("plant", instantiation_token=description.token)
            self.fmu.enter_initialization_mode(start_time=0.0)
            self.set, self.get = self.fmu.set_float64, self.fmu.get_float64
        self.apply(0)
        self.fmu.exit_initialization_mode()

    def apply(self, i):
        inputs = self.request.inputs
        self.set(self.description.of(inputs), [values[i] for values in inputs.values()])

    def outputs(self):
        return self.get(self.description.of(self.request.outputs))

    def do_step(self, time, step):
        self.fmu.do_step(time, step)

    def close(self):
        self.fmu.terminate()
        self.fmu.free_instance()

    def update_discrete_states(self):
        if self.old:
            info = self.fmu.new_discrete_states()
            return bool(info.newDiscreteStatesNeeded), info.nextEventTime
        info = self.fmu.update_discrete_states()
        return info.discrete_states_need_update, info.next_event_time

    def enter_continuous_time_mode(self):
        self.fmu.enter_continuous_time_mode()

    def enter_event_mode(self):
        self.fmu.enter_event_mode()

    def at(self, time, x):
        self.fmu.set_time(time)
        self.fmu.set_continuous_states(x)

    def states(self):
        return self.fmu.get_continuous_states(self.description.states)

    def rates(self):
        get = self.fmu.get_derivatives if self.old else self.fmu.get_continuous_state_derivatives
        return get(self.description.states)

    def indicators(self):
        return self.fmu.get_event_indicators(self.description.indicators)


def main() -> None:
    request = read()
    rows = run(Fmu(request, describe(request)), request)
    write(dict(zip(request.outputs, map(list, zip(*rows, strict=True)), strict=True)))


main()
