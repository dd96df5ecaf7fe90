import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from one_joint import one_joint, swing

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.files.robot_file import save_robot
from flexmodels.mechanics.plant import equations
from pyident.cli.main import main
from pyident.simulation.fmu_runs import FmuRuns
from pyident.simulation.processes.dask_cluster import WorkersError, dask_workers, scheduler_configured
from pyident.sweep.metrics import METRICS, evaluate
from pyident.sweep.run import parameter_study
from pyident.sweep.sampling import latin_hypercube
from pyident.sweep.store import ResultsStore, StudyError
from pyident.sweep.studies import find_study

pytest.importorskip("distributed")
import dask.config

RANGES = {"joint1.viscous": (1.0, 3.0), "joint1.coulomb": (0.5, 1.5)}
SCRIPT = Path(__file__).with_name("interrupted_study.py")


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return export_fmu(equations(one_joint()), tmp_path_factory.mktemp("fmu") / "one.fmu")


@pytest.fixture(scope="module")
def cluster():
    """One Dask cluster for the tests that only need some cluster."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", memory_limit=0) as cluster:
        yield cluster.scheduler.address  # pyright: ignore


def viscous_work(log, reference):
    """A user's metric; not finite where the arm is driven backwards by its friction."""
    return float(np.abs(log["joint1.tau"]).mean())


def complains(log, reference):
    raise KeyError("joint9.tau")


def test_rows_equal_single_runs(fmu, cluster, tmp_path):
    design = latin_hypercube(RANGES, 12)
    found = parameter_study(
        design, fmu, swing(), tmp_path, scheduler=cluster, metrics={**METRICS, "work": viscous_work}
    )
    assert list(found.index) == list(range(12))
    assert set(found["failure"]) == {""}
    np.testing.assert_array_equal(found[list(RANGES)].to_numpy(), design.to_numpy())
    with LoadedFmu(fmu) as loaded:
        reference = loaded.simulate(swing())
        for number in (0, 7):
            log = loaded.simulate(swing(), design.loc[number].to_dict())
            distance = log[["tip.x", "tip.y", "tip.z"]] - reference[["tip.x", "tip.y", "tip.z"]]
            expected = np.sqrt((distance**2).sum(axis=1)).max()
            assert found.loc[number, "tip_error.max"] == pytest.approx(expected, rel=1e-12)
            assert found.loc[number, "torque_rms.joint1"] == pytest.approx(
                np.sqrt((log["joint1.tau"] ** 2).mean()), rel=1e-12
            )
            assert found.loc[number, "work"] == pytest.approx(np.abs(log["joint1.tau"]).mean(), rel=1e-12)
    assert len(set(found["tip_error.max"])) == 12
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "results.parquet").set_index("run"), found)


def test_failed_rows_carry_their_reason(fmu, cluster, tmp_path):
    design = pd.DataFrame({"joint1.viscous": [2.0, np.nan, 1e300, 3.0]})
    found = parameter_study(design, fmu, swing(), tmp_path, scheduler=cluster)
    assert [reason == "" for reason in found["failure"].tolist()] == [True, False, False, True]
    assert np.isnan(found["tip_error.max"].to_numpy()).tolist() == [False, True, True, False]


def test_a_metric_that_fails_names_itself():
    with pytest.raises(ValueError, match=r"metric bad: KeyError: 'joint9\.tau'"):
        evaluate({"bad": complains}, pd.DataFrame(), pd.DataFrame())
    with pytest.raises(ValueError, match=r"metric work is nan"):
        evaluate({"work": lambda log, reference: np.nan}, pd.DataFrame(), pd.DataFrame())


def test_a_killed_worker_loses_nothing(fmu, tmp_path):
    """SIGKILL in the middle of a batch, in the middle of 500 rows."""
    killed = tmp_path / "killed"

    calls: list[int] = []  # every process has its own

    def once(log, reference):
        calls.append(1)
        if len(calls) == 60 and not killed.exists():
            killed.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return float(os.getpid())

    found = parameter_study(
        latin_hypercube(RANGES, 500), fmu, swing(0.04), tmp_path / "out", metrics={"pid": once}, workers=2
    )
    assert killed.exists()
    assert list(found.index) == list(range(500))
    assert set(found["failure"]) == {""}
    assert len(set(found["pid"])) >= 2


def test_a_row_that_kills_every_worker_is_the_only_one_to_fail(fmu, tmp_path):
    def deadly(log, reference):
        if log["joint1.e"].max() < 0.5 * reference["joint1.e"].max():  # held by its friction
            os.kill(os.getpid(), signal.SIGKILL)
        return 1.0

    design = pd.DataFrame({"joint1.viscous": np.linspace(1.0, 3.0, 40)})
    design.loc[20, "joint1.viscous"] = 5e3
    impatient = {"distributed.deploy.lost-worker-timeout": "0.1s"}  # as a busy machine looks at Dask's 15 s
    with dask.config.set(impatient):
        found = parameter_study(design, fmu, swing(), tmp_path, metrics={"one": deadly}, workers=2)
    failed = {run: reason for run, reason in found["failure"].to_dict().items() if reason != ""}
    assert list(failed) == [20]
    assert "its worker failed: KilledWorker" in failed[20]
    assert list(found.index) == list(range(40))


@pytest.mark.slow
def test_ctrl_c_stops_cleanly_and_the_next_call_goes_on(tmp_path):
    """SIGINT to the whole group, as a terminal sends it."""
    words = [sys.executable, str(SCRIPT), str(tmp_path), "1000"]
    first = subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert first.stdout is not None
    while float(first.stdout.readline()) < 0.1:
        pass
    os.killpg(first.pid, signal.SIGINT)
    _, complaints = first.communicate(timeout=60)
    assert first.returncode == 130
    assert "Traceback" not in complaints
    kept = {file.name: file.stat().st_mtime_ns for file in (tmp_path / "parts").iterdir()}
    before = len(pd.concat(pd.read_parquet(tmp_path / "parts" / name) for name in kept))
    assert 100 <= before < 1000
    again = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    assert float(again.stdout.split()[0]) > before / 1000  # it went on where it was
    runs = pd.read_parquet(tmp_path / "results.parquet")["run"]
    assert runs.tolist() == list(range(1000))
    assert _alive(first.pid) == []


def _alive(group: int) -> list[int]:
    """Processes of a process group that still run, after a moment's grace."""
    import psutil

    for _ in range(50):
        left = [p for p in psutil.pids() if psutil.pid_exists(p) and _group(p) == group]
        if not left:
            break
        time.sleep(0.1)
    return left


def _group(pid: int) -> int:
    try:
        return os.getpgid(pid)
    except ProcessLookupError:
        return -1


def test_another_study_is_not_mixed_in(fmu, cluster, tmp_path):
    design = latin_hypercube(RANGES, 4)
    first = parameter_study(design, fmu, swing(), tmp_path, scheduler=cluster)
    pd.testing.assert_frame_equal(parameter_study(design, fmu, swing(), tmp_path, scheduler=cluster), first)
    with pytest.raises(StudyError, match="holds another study"):
        parameter_study(design * 1.01, fmu, swing(), tmp_path, scheduler=cluster)
    with pytest.raises(StudyError, match="holds another study"):
        parameter_study(design, fmu, swing(0.2), tmp_path, scheduler=cluster)


def test_a_part_written_twice_counts_once(tmp_path):
    store = ResultsStore(tmp_path, "a")
    store.add(pd.DataFrame({"run": [2, 3], "failure": ""}))
    store.add(pd.DataFrame({"run": [1, 2], "failure": ""}))
    assert store.rows()["run"].tolist() == [1, 2, 3]


def test_bad_designs(fmu, cluster, tmp_path):
    with pytest.raises(StudyError, match=r"no parameter joint2\.viscous"):
        parameter_study(pd.DataFrame({"joint2.viscous": [1.0]}), fmu, swing(), tmp_path, scheduler=cluster)
    with pytest.raises(StudyError, match="nothing to run"):
        parameter_study(pd.DataFrame(), fmu, swing(), tmp_path, scheduler=cluster)
    assert not list(tmp_path.iterdir())


def test_a_scheduler_that_is_not_there(monkeypatch):
    monkeypatch.setattr("pyident.simulation.processes.dask_cluster._CONNECT_SECONDS", 1)
    with pytest.raises(WorkersError, match=r"no Dask scheduler.*127\.0\.0\.1:9"):
        dask_workers(ThreadPoolExecutor, "tcp://127.0.0.1:9").__enter__()


def test_replicas_run_on_a_cluster_as_on_this_machine(cluster):
    sets = [{"joint1.viscous": v} for v in (1.0, 2.0)]
    with FmuRuns(one_joint()) as runs:
        here = list(runs(swing(), sets))
    with scheduler_configured(cluster), FmuRuns(one_joint()) as runs:
        there = list(runs(swing(), sets))
    for a, b in zip(here, there, strict=True):
        pd.testing.assert_frame_equal(a, b)


def test_the_study_and_its_figure(cluster, tmp_path):
    """Two trajectories of the shipped plan: joint 2's torque depends on its own friction most."""
    study = find_study("parameter_study")
    assert study is not None
    with scheduler_configured(cluster):
        result = study(tmp_path, lambda _: None, runs=42)  # pyright: ignore[reportCallIssue]
    assert all(path.stat().st_size > 10_000 for path in result.figures)
    assert result.rows[0]["value"] == "42; 0"
    assert "most by joint2.coulomb" in result.rows[2]["value"]


def test_sweep_from_a_plan(cluster, tmp_path):
    save_robot(one_joint(), tmp_path / "arm.toml")
    (tmp_path / "mine.py").write_text("def largest(log, reference):\n    return log['joint1.tau'].max()\n")
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'model = "arm.toml"\nexperiment = "identification"\ndesign = "morris"\nruns = 9\n'
        'metrics = ["torque_rms", "mine.py:largest"]\n[parameters]\n"joint1.*c*o*" = 0.25\n'
    )
    words = ["sweep", str(plan), "-o", str(tmp_path / "out"), "--scheduler", cluster]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2
    assert "mine.py is Python code that would be run" in done.output
    words.append("--allow-effects")
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    found = pd.read_parquet(tmp_path / "out" / "results.parquet")
    assert {"joint1.coulomb", "joint1.viscous", "largest", "torque_rms.joint1"} <= set(found)
    indices = pd.read_csv(tmp_path / "out" / "sensitivity.csv", index_col=["result", "parameter"])
    assert (indices["mu_star"].to_numpy() > 0).all()
    plan.write_text(plan.read_text().replace("0.25", "0.3"))
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2
    assert "holds another study" in done.output
