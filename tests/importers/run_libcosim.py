"""libcosim: an execution with this one FMU; its inputs are overridden before each step."""

from libcosimpy.CosimExecution import CosimExecution  # pyright: ignore[reportMissingImports]
from libcosimpy.CosimLogging import (  # pyright: ignore[reportMissingImports]
    CosimLogLevel,
    log_output_level,
)
from libcosimpy.CosimManipulator import CosimManipulator  # pyright: ignore[reportMissingImports]
from libcosimpy.CosimObserver import CosimObserver  # pyright: ignore[reportMissingImports]
from libcosimpy.CosimSlave import CosimLocalSlave  # pyright: ignore[reportMissingImports]
from request import describe, read, write


def main() -> None:
    request = read()
    log_output_level(CosimLogLevel.WARNING)
    execution = CosimExecution.from_step_size(round(1e9 * request.step))
    plant = execution.add_local_slave(CosimLocalSlave(request.fmu, "plant"))
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    description = describe(request)
    set_first, shown = description.of(request.inputs), description.of(request.outputs)
    for reference, value in zip(set_first, request.first.values(), strict=True):
        execution.real_initial_value(plant, reference, value)
    rows = []
    for i in range(len(request.time) - 1):
        manipulator.slave_real_values(plant, set_first, [values[i] for values in request.inputs.values()])
        execution.step()
        rows.append(list(observer.last_real_values(plant, shown)))
    write(dict(zip(request.outputs, map(list, zip(*rows, strict=True)), strict=True)))


main()
