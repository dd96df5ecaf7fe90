"""fmusim, the importer of the Reference-FMUs: a program of its own, fed and read by CSV files."""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

from request import read, write

SAME = 1e-9  # [s] two instants are one


def main() -> None:
    request = read()
    with tempfile.TemporaryDirectory() as folder:
        table, result = Path(folder) / "inputs.csv", Path(folder) / "outputs.csv"
        with table.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["time", *request.inputs])
            writer.writerows(zip(request.time, *request.inputs.values(), strict=True))
        exchange = request.interface == "ModelExchange"
        command = [request.tool, "--interface-type", "me" if exchange else "cs"]
        command += ["--solver", "cvode", "--tolerance", "1e-9"] if exchange else []
        command += ["--event-mode-used"] if request.event_mode else []
        command += ["--start-time", "0", "--stop-time", repr(request.time[-1])]
        command += ["--output-interval", repr(request.step), "--input-file", str(table)]
        command += [word for name, v in request.first.items() for word in ("--start-value", name, repr(v))]
        command += [word for name in request.outputs for word in ("--output-variable", name)]
        done = subprocess.run([*command, "--output-file", str(result), request.fmu], text=True)
        if done.returncode:
            sys.exit(done.returncode)
        with result.open(newline="") as file:
            rows = [{name: float(v) for name, v in row.items()} for row in csv.DictReader(file)]
    last = {round(row["time"] / request.step): row for row in rows if on_grid(row["time"], request.step)}
    write({name: [last[i][name] for i in range(1, len(request.time))] for name in request.outputs})


def on_grid(time: float, step: float) -> bool:
    return abs(time - round(time / step) * step) < SAME


main()
