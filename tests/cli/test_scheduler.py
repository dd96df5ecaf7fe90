"""`--scheduler`: a cluster for whatever simulates."""

from click.testing import CliRunner

from pyident.cli.main import main
from pyident.simulation.processes.dask_cluster import configured_scheduler


def test_the_address_is_configured_for_the_command_alone(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr("pyident.identify", lambda *_, **__: seen.append(configured_scheduler()) or 1 / 0)
    log = tmp_path / "log.csv"
    log.write_text("time\n0\n")
    CliRunner().invoke(main, ["identify", "four_link", str(log), "--scheduler", "tcp://127.0.0.1:1"])
    assert seen == ["tcp://127.0.0.1:1"]
    assert configured_scheduler() is None


def test_a_cluster_that_does_not_answer_ends_in_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr("pyident.simulation.processes.dask_cluster._CONNECT_SECONDS", 1)
    plan = tmp_path / "plan.toml"
    plan.write_text(
        'model = "four_link"\nexperiment = "line"\nruns = 2\n[parameters]\n"joint1.coulomb" = 0.1\n'
    )
    words = ["sweep", str(plan), "-o", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:1"]
    ran = CliRunner().invoke(main, words)
    assert ran.exit_code == 2, ran.output
    assert "no Dask scheduler" in ran.output
    assert "Traceback" not in ran.output
