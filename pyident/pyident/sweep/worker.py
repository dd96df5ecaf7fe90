"""What every worker of a parameter study holds: the FMU, and what its runs are measured against.

Imports little, because every worker imports it.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import pandas as pd

from flexfmu.simulate import LoadedFmu, loaded_fmu
from flexmodels.inputs import Experiment
from pyident.sweep.metrics import Metric, evaluate

Row = tuple[int, dict[str, float]]  # position in the design, parameters


@dataclass(frozen=True)
class Bench:
    """Turns parameters into results."""

    fmu: LoadedFmu
    experiment: Experiment
    reference: pd.DataFrame
    metrics: Mapping[str, Metric]

    def run(self, row: Row) -> dict[str, float | str]:
        """One line of the table; what goes wrong stands in its column `failure`."""
        number, parameters = row
        begin, found, failure = time.perf_counter(), {}, ""
        try:
            log = self.fmu.simulate(self.experiment, parameters)
            found = evaluate(self.metrics, log, self.reference)
        except Exception as error:
            failure = str(error) or type(error).__name__
        return {"run": number, **found, "seconds": time.perf_counter() - begin, "failure": failure}

    def batch(self, rows: Sequence[Row]) -> pd.DataFrame:
        return pd.DataFrame([self.run(row) for row in rows])


@contextmanager
def bench(
    content: bytes, experiment: Experiment, reference: pd.DataFrame, metrics: Mapping[str, Metric]
) -> Iterator[Bench]:
    """A bench with the FMU of this content."""
    with loaded_fmu(content) as fmu:
        yield Bench(fmu, experiment, reference, metrics)
