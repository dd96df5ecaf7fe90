"""CoFMUPy: a coordinator with this one FMU, its inputs from a CSV file."""

import csv
import tempfile
from pathlib import Path

from cofmupy import Coordinator  # pyright: ignore[reportMissingImports]
from request import read, write


def main() -> None:
    request = read()
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "inputs.csv"
        with table.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["t", *request.inputs])
            # half a step early: the coordinator adds up its time and looks for the previous row
            rows = zip([t - request.step / 2 for t in request.time], *request.inputs.values(), strict=True)
            writer.writerows(rows)
        coordinator = Coordinator()
        coordinator.start(
            {
                "fmus": [{"id": "plant", "path": request.fmu, "initialization": request.first}],
                "connections": [
                    {
                        "source": {"type": "csv", "path": str(table), "variable": name},
                        "target": [{"type": "fmu", "id": "plant", "variable": name}],
                    }
                    for name in request.inputs
                ],
            }
        )
        coordinator.run_simulation(request.step, request.time[-1] - request.step / 2)
    results = coordinator.get_results()
    write({name: [float(v) for v in results["plant", name]] for name in request.outputs})


main()
