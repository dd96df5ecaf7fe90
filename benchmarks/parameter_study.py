"""A parameter study with one worker and with two: what the second one brings.

    python -m benchmarks.parameter_study

200 runs of four_link, 5 s of the paper's identification experiment each. "All" is the whole call: export of
the FMU, start of the Dask cluster, runs, table; "runs" is the rate at which rows arrive between the first and
the last batch. Rounds alternate between one and two workers, so that other work on the machine hits both; the
ratio is the median. "Bare" runs half as many of the same simulations in processes without Dask: what the
machine itself gives at that moment. Without idle cores nothing can be learnt from the ratios.
"""

import argparse
import sys
import tempfile
import time
from multiprocessing import get_context
from pathlib import Path
from statistics import median

import pandas as pd

from flexfmu.build import export_fmu
from flexmodels.experiment import Experiment, identification
from flexmodels.plant import equations
from flexmodels.robot import Robot
from flexmodels.robot_file import load_robot
from pyident.parameter_study import parameter_study
from pyident.pipeline import loaded_fmu
from pyident.sampling import latin_hypercube

SECONDS = 5.0
SHARE = 0.25
VARIED = (".k[", ".coulomb", ".viscous")


def design(robot: Robot, runs: int) -> pd.DataFrame:
    """Stiffnesses and friction, plus and minus 25 %."""
    own = {name: value for name, value in robot.parameters.items() if any(v in name for v in VARIED)}
    return latin_hypercube({n: ((1 - SHARE) * v, (1 + SHARE) * v) for n, v in own.items()}, runs)


def study(sets: pd.DataFrame, robot: Robot, experiment: Experiment, workers: int) -> tuple[float, float]:
    """Wall-clock seconds of the whole call, and seconds per row between the first and the last batch."""
    arrived: list[tuple[float, float]] = []
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        found = parameter_study(
            sets, robot, experiment, folder, workers=workers,
            progress=lambda fraction: arrived.append((time.perf_counter(), fraction)),
        )  # fmt: skip
    assert set(found["failure"]) == {""}
    (first, done), (last, _) = arrived[0], arrived[-1]
    return time.perf_counter() - begin, (last - first) / (1 - done) / len(sets)


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
    return (time.perf_counter() - begin) / runs


def _simulate(content: bytes, experiment: Experiment, runs: int, start) -> None:
    with loaded_fmu(content) as fmu:
        start.wait()
        for _ in range(runs):
            fmu.simulate(experiment)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=3)
    words = parser.parse_args()
    robot = load_robot("four_link")
    experiment, sets = identification(robot, duration=SECONDS), design(robot, words.runs)
    with tempfile.TemporaryDirectory() as folder:
        content = export_fmu(equations(robot), Path(folder) / "arm.fmu", derivatives=False).read_bytes()
    rows = []
    for number in range(words.rounds):
        for workers in (1, 2):
            whole, per_row = study(sets, robot, experiment, workers)
            control = bare(content, experiment, words.runs // 2, workers)
            rows.append((number, workers, whole, 1e3 * per_row, 1e3 * control))
            print(f"round {number + 1}, workers {workers}: {whole:.1f} s", file=sys.stderr)
    table = pd.DataFrame(rows, columns=["round", "workers", "all [s]", "runs [ms each]", "bare [ms each]"])
    print(table.to_string(index=False, float_format="{:.3g}".format))
    by_round = table.pivot(index="round", columns="workers")
    for name in ("all [s]", "runs [ms each]", "bare [ms each]"):
        print(
            f"two workers against one, {name.split()[0]}: {median(by_round[name][1] / by_round[name][2]):.2f}"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
