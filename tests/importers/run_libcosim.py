"""libcosim: an execution with this one FMU, or of an SSP; its inputs are overridden before each step."""

import tempfile
import zipfile

from libcosimpy.CosimExecution import CosimExecution  # pyright: ignore[reportMissingImports]
from libcosimpy.CosimLogging import (  # pyright: ignore[reportMissingImports]
    CosimLogLevel,
    log_output_level,
)
from libcosimpy.CosimManipulator import CosimManipulator  # pyright: ignore[reportMissingImports]
from libcosimpy.CosimObserver import CosimObserver  # pyright: ignore[reportMissingImports]
from libcosimpy.CosimSlave import CosimLocalSlave  # pyright: ignore[reportMissingImports]
from request import Request, describe, read, write


def main() -> None:
    request = read()
    log_output_level(CosimLogLevel.WARNING)
    step = round(1e9 * request.step)
    if request.fmu.endswith(".ssp"):
        with tempfile.TemporaryDirectory() as folder:
            with zipfile.ZipFile(request.fmu) as archive:
                archive.extractall(folder)
            execution = CosimExecution.from_ssp_file(f"{folder}/SystemStructure.ssd", step)
            rows = _run(execution, request)
    else:
        execution = CosimExecution.from_step_size(step)
        plant = execution.add_local_slave(CosimLocalSlave(request.fmu, "plant"))
        for reference, value in zip(
            describe(request).of(request.inputs), request.first.values(), strict=True
        ):
            execution.real_initial_value(plant, reference, value)
        rows = _run(execution, request)
    write(dict(zip(request.outputs, map(list, zip(*rows, strict=True)), strict=True)))


def _run(execution, request: Request) -> list[list[float]]:
    """Outputs after each step; `component::variable` in a system, whose inputs are all of one component."""
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator)
    execution.add_observer(observer)
    (fed, set_first), (read_from, shown) = (
        _of(execution, names) for names in (request.inputs, request.outputs)
    )
    rows = []
    for i in range(len(request.time) - 1):
        manipulator.slave_real_values(fed, set_first, [values[i] for values in request.inputs.values()])
        execution.step()
        rows.append(list(observer.last_real_values(read_from, shown)))
    return rows


def _of(execution, names) -> tuple[int, list[int]]:
    """The component that has the variables, and their references."""
    component = next(iter(names)).rpartition("::")[0] or "plant"
    slave = execution.slave_index_from_instance_name(component)
    listed = {v.name.decode(): v.reference for v in execution.slave_variables(slave)}
    return slave, [listed[name.rpartition("::")[2]] for name in names]


main()
