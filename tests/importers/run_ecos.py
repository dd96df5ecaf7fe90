"""ecos: a system of this one FMU, or an SSP; its inputs are set before each step."""

import ctypes
import sys
from pathlib import Path

from request import Request, read, write

# its library needs that of the package tbb, which lies beside the interpreter
ctypes.CDLL(str(Path(sys.executable).parents[1] / "lib" / "libtbb.so.12"), mode=ctypes.RTLD_GLOBAL)

from ecospy import (  # noqa: E402 # pyright: ignore[reportMissingImports]
    EcosLib,
    EcosSimulation,
    EcosSimulationStructure,
)


def main() -> None:
    request = read()
    EcosLib.set_log_level("warn")
    if request.fmu.endswith(".ssp"):
        with EcosSimulation(ssp_path=request.fmu, step_size=request.step) as simulation:
            simulation.init()
            rows = _run(simulation, request, "")
    else:
        with EcosSimulationStructure() as structure:
            structure.add_model("plant", request.fmu)
            first = {f"plant::{name}": value for name, value in request.first.items()}
            structure.add_parameter_set("initialValues", first)
            with EcosSimulation(structure=structure, step_size=request.step) as simulation:
                simulation.init(parameter_set="initialValues")
                rows = _run(simulation, request, "plant::")
    write(dict(zip(request.outputs, map(list, zip(*rows, strict=True)), strict=True)))


def _run(simulation, request: Request, owner: str) -> list[list[float]]:
    """Outputs after each step; names in a system begin with their component already."""
    rows = []
    for i in range(len(request.time) - 1):
        for name, values in request.inputs.items():
            simulation.set_real(owner + name, values[i])
        simulation.step()
        rows.append([simulation.get_real(owner + name) for name in request.outputs])
    return rows


main()
