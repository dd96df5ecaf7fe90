"""Time and memory of building and solving the regression of four_link on one core, each in its own process.

    python -m benchmarks.solve -o out

ours        Phi compiled, blocks folded into triangles, SVD of these; nothing is stored
from disk   the same, and the log is read from a Parquet file and conditioned on the way
lstsq       the matrix stored, columns scaled alike, then numpy.linalg.lstsq or scipy.linalg.lstsq

Memory is the process's peak, the interpreter and its libraries included.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
from benchmarks.measure import in_own_process, on_one_core, peak_memory

from flexmodels.robot_file import load_robot
from pyident.conditioning import Conditioned
from pyident.problem import Problem
from pyident.regressor import Motion, regressor_blocks
from pyident.solve import reduce, solve

TOOLS = ("ours", "numpy lstsq", "scipy lstsq")
_RCOND = 1e-10


def problem(samples: int) -> Problem:
    """A smooth motion of four_link and its torques with noise."""
    robot, rng = load_robot("four_link"), np.random.default_rng(0)
    n, clock = len(robot.coordinates), 0.004 * np.arange(samples)
    w, phase = rng.uniform(1, 30, n), rng.uniform(0, 6, n)
    q, dq, ddq = (np.empty((samples, n)) for _ in range(3))
    for j in range(n):
        angle = w[j] * clock + phase[j]
        q[:, j], dq[:, j] = 0.2 * np.sin(angle), 0.2 * w[j] * np.cos(angle)
        ddq[:, j] = -(w[j] ** 2) * q[:, j]
    motion = Motion(q, dq, ddq)
    p, target = np.array(list(robot.parameters.values())), rng.normal(size=(samples, n))
    for at, Phi in regressor_blocks(robot, motion):
        target[at] += np.einsum("bcp,p->bc", Phi, p)
    return Problem(robot, (Conditioned(motion, target, np.broadcast_to(1.0, target.shape), 1),))


def ours(of: Problem) -> np.ndarray:
    return solve(reduce(of.blocks(), of.rows, of.columns)).p


def stored(of: Problem, tool: str) -> np.ndarray:
    A = np.concatenate([block.copy().reshape(-1, len(of.columns)) for block, _ in of.blocks()])
    y = np.concatenate([block.ravel() for _, block in of.blocks()])
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0] = 1.0
    A /= scale
    if tool == "scipy lstsq":
        from scipy.linalg import lstsq

        return np.asarray(lstsq(A, y, cond=_RCOND, overwrite_a=True)[0]) / scale  # pyright: ignore
    return np.linalg.lstsq(A, y, rcond=_RCOND)[0] / scale


def job(tool: str, samples: int) -> dict[str, Any]:
    """One run: seconds of wall clock, peak MB and what the solution predicts."""
    on_one_core()
    of = problem(samples)
    begin = time.perf_counter()
    p = ours(of) if tool == "ours" else stored(of, tool)
    seconds = time.perf_counter() - begin
    _, Phi = next(iter(regressor_blocks(of.robot, of.parts[0].motion)))  # pyright: ignore
    return {"seconds": seconds, "peak MB": peak_memory(), "prediction": (Phi[:50] @ p).ravel().tolist()}


def file_job(path: str) -> dict[str, Any]:
    """From the file to the solution."""
    from pyident.conditioned_file import prepared
    from pyident.log_file import log_file

    on_one_core()
    robot = load_robot("four_link")
    begin = time.perf_counter()
    ours(Problem(robot, (prepared(log_file(path), robot),)))
    return {"seconds": time.perf_counter() - begin, "peak MB": peak_memory()}


def rows(samples: int, lengths: list[int], tools: tuple[str, ...] = TOOLS) -> list[dict[str, Any]]:
    """Every tool on so many samples; ours from disk on logs of several lengths."""
    found, predictions = [], {}
    for tool in tools:
        result = in_own_process("benchmarks.solve", "--job", tool, "--samples", str(samples))
        predictions[tool] = np.array(result.pop("prediction"))
        wrong = np.abs(predictions[tool] - predictions["ours"]).max() / np.abs(predictions["ours"]).max()
        found.append({"tool": tool, "samples": samples, **result, "differs from ours": wrong})
    if lengths:
        from benchmarks.long_log import one_period, write_long_log

        period = one_period(load_robot("four_link"))
        with TemporaryDirectory() as folder:
            for length in lengths:
                path = Path(folder) / f"{length}.parquet"
                write_long_log(period, length, path)
                result = in_own_process("benchmarks.solve", "--job", str(path))
                found.append({"tool": "ours, from disk", "samples": length, **result})
    return found


def figure(table: pd.DataFrame, path: Path) -> None:
    import matplotlib.pyplot as plt

    disk = table[table["tool"] == "ours, from disk"]
    fig, axes = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
    for ax, column in zip(axes, ("seconds", "peak MB"), strict=True):
        ax.plot(disk["samples"] / 15_000, disk[column], "o-")
        ax.set(xlabel="length of the log [min at 250 Hz]", ylabel=column, ylim=(0, None))
        ax.grid(alpha=0.3)
    fig.savefig(path, dpi=150)
    plt.close(fig)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("-o", "--out", type=Path, default=Path("out"), help="folder of table and figure")
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--lengths", type=int, nargs="*", default=[15_000, 90_000, 450_000, 900_000])
    parser.add_argument("--job", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.job:
        result = job(given.job, given.samples) if given.job in TOOLS else file_job(given.job)
        print(json.dumps(result))
        return 0
    given.out.mkdir(parents=True, exist_ok=True)
    table = pd.DataFrame(rows(given.samples, given.lengths))
    table.to_csv(given.out / "solve.csv", index=False)
    figure(table, given.out / "solve.png")
    print(table.to_string(index=False, float_format="{:.3g}".format))
    return 0


if __name__ == "__main__":
    sys.exit(main())
