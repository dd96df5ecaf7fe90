"""PathSim with pathsim-fmi: the FMU as a block that steps itself, or that PathSim's solver integrates."""

from pathsim import Connection, Simulation  # pyright: ignore[reportMissingImports]
from pathsim.blocks import Scope, Source  # pyright: ignore[reportMissingImports]
from pathsim.solvers import RKDP54  # pyright: ignore[reportMissingImports]
from pathsim_fmi import CoSimulationFMU, ModelExchangeFMU  # pyright: ignore[reportMissingImports]
from request import Request, read, write


def held(request: Request, name: str):
    """The input as a function of time, constant from half a step before a communication point."""
    values = request.inputs[name]
    return lambda t: values[min(int(t / request.step + 0.5), len(values) - 1)]


def simulate(request: Request, plant, period: float | None = None, **solver) -> list[list[float]]:
    """The block with a source at each input and a scope at the outputs; what the scope saw."""
    fmu = plant.fmu_wrapper
    sources = [Source(held(request, name)) for name in fmu.input_refs]
    ports = [list(fmu.output_refs).index(name) for name in request.outputs]
    scope = Scope(labels=request.outputs, sampling_period=period)
    wires = [Connection(source, plant[i]) for i, source in enumerate(sources)]
    wires += [Connection(plant[port], scope[i]) for i, port in enumerate(ports)]
    run = Simulation([*sources, plant, scope], wires, log=False, **solver)
    if isinstance(plant, ModelExchangeFMU):
        # pathsim-fmi 0.1.1 leaves out the first event iteration; by now the inputs have become 0
        for name, value in request.first.items():
            fmu.set_variable(name, value)
        plant._handle_event(0.0)
    run.run(request.time[-1])
    return scope.read()[1].T.tolist()


def co_simulation(request: Request) -> list[list[float]]:
    plant = CoSimulationFMU(request.fmu, start_values=request.first, dt=request.step)
    seen = simulate(request, plant, dt=request.step)
    return seen[: len(request.time) - 1]  # the block steps from t to t + dt at t, so it shows t + dt at t


def model_exchange(request: Request) -> list[list[float]]:
    plant = ModelExchangeFMU(request.fmu, start_values=request.first)
    accuracy = {"Solver": RKDP54, "tolerance_lte_abs": 1e-10, "tolerance_lte_rel": 1e-8}
    seen = simulate(request, plant, request.step, dt=request.step / 8, **accuracy)
    return seen[1 : len(request.time)]


def main() -> None:
    request = read()
    run = model_exchange if request.interface == "ModelExchange" else co_simulation
    rows = run(request)
    write(dict(zip(request.outputs, map(list, zip(*rows, strict=True)), strict=True)))


main()
