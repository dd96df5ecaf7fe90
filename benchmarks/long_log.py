"""Logs of any length: one period of four_link in the paper's identification experiment, over and over."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from flexmodels.experiment import identification
from flexmodels.robot import Robot
from pyident.simulation.fmu_runs import simulate_robot

PERIOD = 1025  # samples: 4.1 s at 250 Hz
SETTLED = 5  # periods until the motion repeats itself
RATE = 250  # Hz


def one_period(robot: Robot) -> dict[str, np.ndarray]:
    """The columns of the last of some periods of the simulated motion; its torques repeat too."""
    experiment = identification(robot, duration=(SETTLED + 1) * PERIOD / RATE)
    first = experiment.feedforward[np.arange(len(experiment.time)) % PERIOD]
    frame = simulate_robot(robot, replace(experiment, feedforward=first)).iloc[-PERIOD - 1 : -1]
    return {name: frame[name].to_numpy() for name in frame if name != "time"}


def write_long_log(period: dict[str, np.ndarray], samples: int, path: Path) -> None:
    """Repeat the period in a Parquet file of `samples` rows, with sensor noise."""
    rng = np.random.default_rng(0)
    with pq.ParquetWriter(path, pa.schema([(n, pa.float64()) for n in ("time", *period)])) as writer:
        for start in range(0, samples, 64 * PERIOD):
            at = np.arange(start, min(start + 64 * PERIOD, samples))
            columns = {name: x[at % PERIOD] + 1e-9 * rng.normal(size=len(at)) for name, x in period.items()}
            writer.write_table(pa.table({"time": at / RATE} | columns))
