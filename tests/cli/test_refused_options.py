"""Options that do not belong together end in a sentence before anything is computed."""

import pytest
from click.testing import CliRunner
from one_joint import one_joint, swing
from two_link_logs import TWO_LINK

from flexmodels.files.robot_file import save_robot
from pyident.cli.main import main
from pyident.logs.log import Log, write_log
from pyident.simulation.fmu_runs import simulate_robot


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("identify", "--parameters", "k"), "--parameters and --interface belong to an FMU"),
        (("identify", "--set", "joint1.coulomb=1"), "--set belongs to an FMU as the model, or to a robot"),
        (("identify", "--set-in", "log.csv", "servo.kp=1"), "--set-in belongs to a robot with a [servo]"),
        (
            ("identify", "--estimator", "oe", "--robust"),
            "--robust is the estimator irls; leave --estimator out",
        ),
        (("identify", "--estimator", "wls", "--refine"), "--refine is the estimator oe"),
        (("identify", "--robust", "--refine"), "give one of them"),
        (("diagnose", "--parameters", "k"), "--parameters and --interface belong to an FMU"),
    ],
)
def test_they_are_refused(words, sentence, tmp_path, monkeypatch):
    for verb in ("identify", "refine", "diagnose"):
        monkeypatch.setattr(f"pyident.{verb}", None)  # calling it would be a fault, with exit code 70
    log = tmp_path / "log.csv"
    log.write_text("time\n0\n")
    command, *options = words
    done = CliRunner().invoke(main, [command, str(TWO_LINK), str(log), *options])
    assert done.exit_code == 2, done.output
    assert sentence in " ".join(done.output.split())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("identify", "model.fmu", "log.csv"), "name the parameters of model.fmu to identify, such as"),
        (("export", "emps", "-o", "emps.fmu"), "export the plant alone (--part plant)"),
        (
            ("compare", "four_link", "R=1.3"),
            "there is no log R=1.3; if it is a value, give an option for each: --set A=1",
        ),
    ],
)
def test_what_was_meant_is_named(words, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, list(words))
    assert done.exit_code == 2, done.output
    assert sentence in " ".join(done.output.split())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words",
    [("excite", "four_link"), ("log", "import", "log.csv", "--mapping", "m.toml"), ("export", "four_link")],
)
def test_a_file_to_write_is_asked_for_before_anything_runs(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "log.csv").write_text("time\n0\n")
    done = CliRunner().invoke(main, list(words))
    assert done.exit_code == 2, done.output
    assert "Missing option '-o'" in done.output


def test_what_judges_or_settles_an_identification_is_looked_at_before_it(tmp_path, monkeypatch):
    """Minutes of work are not lost by a path with a slip in it."""
    monkeypatch.setattr("pyident.verbs.fit._identified", None)
    log = tmp_path / "log.parquet"
    write_log(Log(simulate_robot(one_joint(), swing(2.0)), "log"), log)
    robot = tmp_path / "robot.toml"
    save_robot(one_joint(), robot)
    for options, sentence in (
        (("--holdout", str(tmp_path / "nowhere.csv")), "nowhere.csv"),
        (("--prior", "nowhere.toml"), "nowhere.toml"),
        (("--prior", "four_link"), "give a model of the same arm"),
    ):
        done = CliRunner().invoke(main, ["identify", str(robot), str(log), *options])
        assert done.exit_code == 2, done.output
        assert sentence in " ".join(done.output.split())
