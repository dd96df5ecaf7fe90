"""Time and memory of building and solving the regression of four_link on one core, each in its own process.

    python -m benchmarks.solve -o out

ours        Phi compiled, blocks folded into triangles, SVD of these; nothing is stored
from disk   the same, and the log is read from a Parquet file and conditioned on the way
lstsq       the matrix stored, columns scaled alike, then numpy.linalg.lstsq or scipy.linalg.lstsq

Time is CPU time. Memory is the process's peak, the interpreter and its libraries included.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
from benchmarks.least_squares import TOOLS
from benchmarks.long_log import one_period, write_long_log
from benchmarks.measure import in_own_process
from benchmarks.results import command, drawn, keep

from flexmodels.files.robot_file import load_robot


def rows(samples: int, lengths: list[int], tools: tuple[str, ...] = TOOLS) -> list[dict[str, Any]]:
    """Every tool on so many samples; ours from disk on logs of several lengths."""
    found, predictions = [], {}
    for tool in tools:
        result = in_own_process("benchmarks.least_squares", tool, str(samples))
        predictions[tool] = np.array(result.pop("prediction"))
        wrong = np.abs(predictions[tool] - predictions["ours"]).max() / np.abs(predictions["ours"]).max()
        found.append({"tool": tool, "samples": samples, **result, "differs from ours": wrong})
    if lengths:
        period = one_period(load_robot("four_link"))
        with TemporaryDirectory() as folder:
            for length in lengths:
                path = Path(folder) / f"{length}.parquet"
                write_long_log(period, length, path)
                result = in_own_process("benchmarks.least_squares", str(path))
                found.append({"tool": "ours, from disk", "samples": length, **result})
    return found


def figure(table: pd.DataFrame, path: Path) -> None:
    """Of our own runs from disk."""
    disk = table[table["tool"] == "ours, from disk"]
    with drawn(path, columns=2) as axes:
        for ax, column in zip(axes, ("seconds", "peak MB"), strict=True):
            ax.plot(disk["samples"] / 15_000, disk[column], "o-")
            ax.set(xlabel="length of the log [min at 250 Hz]", ylabel=column, ylim=(0, None))


def main() -> int:
    parser = command(__doc__)
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--lengths", type=int, nargs="*", default=[15_000, 90_000, 450_000, 900_000])
    given = parser.parse_args()
    keep(pd.DataFrame(rows(given.samples, given.lengths)), "solve", given.out, figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
