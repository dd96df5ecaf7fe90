"""Parameter sets x FMU x experiment -> table of results, on the processes of a Dask cluster.

Finished batches go to disk at once, so that a study that was stopped goes on where it was.
"""

import hashlib
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, Future, as_completed
from contextlib import closing
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from flexfmu.build import export_fmu
from flexfmu.names import fmi_name
from flexfmu.simulate import LoadedFmu, loaded_fmu
from flexmodels.atomic import replacing
from flexmodels.inputs import Experiment
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot
from flexmodels.scratch import scratch_folder
from pyident.simulation.processes.dask_cluster import configured_scheduler, dask_cluster
from pyident.simulation.processes.tools import Processes
from pyident.sweep.metrics import METRICS, Metric, evaluate
from pyident.sweep.plan import StudyPlan
from pyident.sweep.store import ResultsStore, StudyError
from pyident.sweep.summary import sensitivities
from pyident.sweep.worker import Bench, Row, bench

_BATCH_SECONDS = 0.5  # of simulation per task: a hundred times what Dask spends on one
_BATCHES = 8  # per worker at least, so that all end at about the same time

Progress = Callable[[float], None]


def parameter_study(
    design: pd.DataFrame,
    model: Robot | str | Path,
    experiment: Experiment,
    folder: str | Path,
    *,
    metrics: Mapping[str, Metric] = METRICS,
    reference: pd.DataFrame | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Simulate every row of `design` and return the table that is also written to folder/results.parquet.

    design      a row per run; columns are public parameter names (`joint1.k[1]`), values in SI units
    model       a robot or an FMU file; what the design does not name keeps its own value
    metrics     name -> function(log, reference) -> number or numbers by name (see `metrics`)
    reference   log to compare with, none: a run with the model's own parameters
    scheduler   address of a Dask cluster; none: the configured one, else `workers` processes here (all cores)
    progress    called with the fraction done

    Index `run`, the row's position in the design; columns: parameters, results, `seconds`, and `failure`, why
    a run has no results (else ""). Called again with the same folder after an interrupt, it does the rest.
    Called from a script, it has to stand under `if __name__ == "__main__":`, because it starts processes.
    Raises StudyError, WorkersError, SimulationError, BuildError.
    """
    design = design.reset_index(drop=True)
    with dask_cluster(scheduler or configured_scheduler(), workers, bench.__module__) as cluster:
        content = _content(model)  # while the workers start
        with loaded_fmu(content) as fmu:
            _check(design, fmu)
            begin = time.perf_counter()
            nominal = fmu.simulate(experiment)
            seconds = time.perf_counter() - begin
            reference = nominal if reference is None else reference
            of = _fingerprint(design, fmu.description.guid or "", experiment, reference, metrics)
        _check_metrics(metrics, nominal, reference)
        with closing(ResultsStore(folder, of)) as store:
            left = _left(design, store)
            if left:
                with cluster.holding(partial(bench, content, experiment, reference, metrics)) as processes:
                    _Study(processes, store, len(design), progress).run(
                        _batches(left, seconds, processes.count)
                    )
            return store.finish(design)


def one_run(plan: StudyPlan) -> float:
    """Seconds that one run of the plan's model takes. Raises SimulationError, BuildError."""
    with loaded_fmu(_content(plan.model)) as fmu:
        begin = time.perf_counter()
        fmu.simulate(plan.experiment)
        return time.perf_counter() - begin


def run_plan(
    plan: StudyPlan, folder: str | Path, workers: int | None = None, progress: Progress | None = None
) -> pd.DataFrame:
    """The table of `parameter_study`, and sensitivity.csv beside it where the design allows it."""
    found = parameter_study(
        plan.design,
        plan.model,
        plan.experiment,
        folder,
        metrics=plan.metrics,
        workers=workers,
        progress=progress,
    )
    if plan.method is not None:
        with replacing(Path(folder) / "sensitivity.csv") as file:
            sensitivities(plan.method, plan.ranges, found).to_csv(file)
    return found


class _Study:
    """Batches on their way to the store."""

    def __init__(
        self, processes: Processes[Bench], store: ResultsStore, total: int, progress: Progress | None
    ):
        self._processes, self._store, self._total, self._progress = processes, store, total, progress
        self._done = len(store.rows())

    def run(self, batches: Sequence[Sequence[Row]]) -> None:
        """All batches at once; then, one by one, the rows of those that took their worker with them."""
        waiting = {self._processes.submit(Bench.batch, batch): batch for batch in batches}
        suspects: list[Row] = []
        try:
            for future in as_completed(dict(waiting)):
                batch = waiting.pop(future)
                if future.exception() is None:
                    self._keep(future.result())
                else:
                    suspects += batch
        finally:
            for future in waiting:
                self._salvage(future)
        for row in suspects:
            self._alone(row)

    def _keep(self, rows: pd.DataFrame) -> None:
        self._store.add(rows)
        self._done += len(rows)
        if self._progress:
            self._progress(self._done / self._total)

    def _alone(self, row: Row) -> None:
        """With no other run beside it, a worker that dies is this row's doing."""
        try:
            self._keep(self._processes.submit(Bench.batch, [row]).result())
        except CancelledError:
            raise
        except Exception as error:
            reason = f"its worker failed: {type(error).__name__}: {error}"
            self._keep(pd.DataFrame([{"run": row[0], "seconds": np.nan, "failure": reason}]))

    def _salvage(self, future: "Future[pd.DataFrame]") -> None:
        """After an interrupt: keep what is there, drop the rest."""
        if future.done() and not future.cancelled() and future.exception() is None:
            self._keep(future.result())
        else:
            future.cancel()


def _check_metrics(metrics: Mapping[str, Metric], nominal: pd.DataFrame, reference: pd.DataFrame) -> None:
    try:
        evaluate(metrics, nominal, reference)
    except ValueError as error:
        raise StudyError(f"{error}, on the model's own run; correct the metric") from None


def _content(model: Robot | str | Path) -> bytes:
    if not isinstance(model, Robot):
        if not Path(model).is_file():
            raise StudyError(f"there is no FMU {model}; check the path")
        return Path(model).read_bytes()
    with scratch_folder() as folder:
        return export_fmu(equations(model), folder / "plant.fmu", light=True).read_bytes()


def _check(design: pd.DataFrame, fmu: LoadedFmu) -> None:
    if design.empty:
        raise StudyError("the design has no rows or no columns, so there is nothing to run")
    known = {v.name for v in fmu.description.modelVariables if v.causality == "parameter"}
    for name in design:
        if fmi_name(str(name)) not in known:
            raise StudyError(
                f"the model has no parameter {name}; see the [parameters] of `pyident export --json`"
            )
        if not np.issubdtype(design[name].to_numpy().dtype, np.number):
            raise StudyError(f"column {name} of the design is not numeric")


def _fingerprint(
    design: pd.DataFrame,
    model: str,
    experiment: Experiment,
    reference: pd.DataFrame,
    metrics: Mapping[str, Metric],
) -> str:
    digest = hashlib.sha256(repr((model, list(design), list(reference), sorted(metrics))).encode())
    arrays = (design, reference, experiment.time, experiment.reference, experiment.feedforward)
    for values in arrays:
        digest.update(np.ascontiguousarray(values, dtype=float).tobytes())
    return digest.hexdigest()


def _left(design: pd.DataFrame, store: ResultsStore) -> list[Row]:
    done = set(store.rows()["run"])
    return [
        (number, {str(name): float(value) for name, value in row.items()})
        for number, row in enumerate(design.to_dict("records"))
        if number not in done
    ]


def _batches(rows: Sequence[Row], seconds: float, workers: int) -> list[Sequence[Row]]:
    """seconds: what one run takes."""
    size = max(1, min(round(_BATCH_SECONDS / seconds), len(rows) // (_BATCHES * workers)))
    return [rows[i : i + size] for i in range(0, len(rows), size)]
