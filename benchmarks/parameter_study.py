"""A parameter study with one worker and with more: what each further one brings.

    python -m benchmarks.parameter_study -o out

200 runs of four_link, 5 s of the paper's identification experiment each. "All" is the whole call: export of
the FMU, start of the Dask cluster, runs, table; "runs" is the rate at which rows arrive between the first and
the last batch. Rounds alternate between the numbers of workers, so that other work on the machine hits them
alike; the speed-up is the median of the rounds. "Bare" runs half as many of the same simulations in bare
processes: what the machine itself gives at that moment. Without idle cores nothing can be learnt from it.
"""

import os
import sys
import tempfile
import time
from multiprocessing import get_context
from pathlib import Path

import pandas as pd
from benchmarks.results import command, drawn, keep

from flexfmu.simulate import loaded_fmu
from flexmodels.inputs import Experiment

# The workers import this file once more, as any script; what only the script needs is imported further down.

SECONDS = 5.0
SHARE = 0.25
VARIED = (".k[", ".coulomb", ".viscous")
MEASURED = ("all [s]", "runs [ms each]", "bare [ms each]")


def design(robot, runs: int) -> pd.DataFrame:
    """Stiffnesses and friction, plus and minus 25 %."""
    from pyident.sweep.sampling import latin_hypercube

    own = {name: value for name, value in robot.parameters.items() if any(v in name for v in VARIED)}
    return latin_hypercube({n: ((1 - SHARE) * v, (1 + SHARE) * v) for n, v in own.items()}, runs)


def study(sets: pd.DataFrame, robot, experiment: Experiment, workers: int) -> tuple[float, float]:
    """Wall-clock seconds of the whole call, and seconds per row between the first and the last batch."""
    from pyident.sweep.run import parameter_study

    arrived: list[tuple[float, float]] = []
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        found = parameter_study(
            sets, robot, experiment, folder, workers=workers,
            progress=lambda fraction: arrived.append((time.perf_counter(), fraction)),
        )  # fmt: skip
    took = time.perf_counter() - begin
    assert set(found["failure"]) == {""}
    (first, done), (last, _) = arrived[0], arrived[-1]
    return took, (last - first) / (1 - done) / len(sets)


def bare(content: bytes, experiment: Experiment, runs: int, workers: int) -> float:
    """Seconds per run of plain processes that share the runs, loading not counted."""
    context = get_context("spawn")
    start = context.Barrier(workers + 1)
    work = [
        context.Process(target=_simulate, args=(content, experiment, runs // workers, start))
        for _ in range(workers)
    ]
    for process in work:
        process.start()
    start.wait()
    begin = time.perf_counter()
    for process in work:
        process.join()
    return (time.perf_counter() - begin) / (runs // workers * workers)


def _simulate(content: bytes, experiment: Experiment, runs: int, start) -> None:
    with loaded_fmu(content) as fmu:
        start.wait()
        for _ in range(runs):
            fmu.simulate(experiment)


def measured(runs: int, rounds: int, numbers: list[int]) -> pd.DataFrame:
    """A row per round and number of workers."""
    from flexfmu.build import export_fmu
    from flexmodels.experiment import identification
    from flexmodels.files.robot_file import load_robot
    from flexmodels.mechanics.plant import equations

    robot = load_robot("four_link")
    experiment, sets = identification(robot, duration=SECONDS), design(robot, runs)
    with tempfile.TemporaryDirectory() as folder:
        content = export_fmu(equations(robot), Path(folder) / "arm.fmu", light=True).read_bytes()
    rows = []
    for number in range(rounds):
        for workers in numbers:
            whole, per_row = study(sets, robot, experiment, workers)
            control = bare(content, experiment, runs // 2, workers)
            rows.append((number, workers, whole, 1e3 * per_row, 1e3 * control))
            print(f"round {number + 1}, workers {workers}: {whole:.1f} s", file=sys.stderr)
    return pd.DataFrame(rows, columns=["round", "workers", *MEASURED])


def speedups(table: pd.DataFrame) -> pd.DataFrame:
    """Index: numbers of workers; times faster than with the smallest number, median of the rounds."""
    by_round = table.pivot(index="round", columns="workers")
    return pd.DataFrame(
        {
            name.split()[0]: (1 / by_round[name].div(by_round[name].iloc[:, 0], axis=0)).median()
            for name in MEASURED
        }
    )


def figure(table: pd.DataFrame, path: Path) -> None:
    found = speedups(table)
    with drawn(path) as (ax,):
        for name, label in (("all", "the whole study"), ("runs", "its runs"), ("bare", "bare processes")):
            ax.plot(found.index, found[name], "o-", label=label)
        ax.plot(found.index, found.index / found.index[0], "k--", lw=0.8, label="ideal")
        ax.set(xlabel="workers", ylabel="times faster than with one", xticks=found.index, ylim=(0, None))
        ax.set_title(f"{os.cpu_count()} cores", fontsize=9, loc="right")


def main() -> int:
    parser = command(__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2])
    given = parser.parse_args()
    table = measured(given.runs, given.rounds, given.workers)
    keep(table, "parameter_study", given.out, figure)
    print("\ntimes faster\n" + speedups(table).to_string(float_format="{:.2f}".format))
    return 0


if __name__ == "__main__":
    sys.exit(main())
