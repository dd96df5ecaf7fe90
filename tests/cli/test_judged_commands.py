"""What `compare`, `diagnose`, `add` and `identify` say, write and end with, from outcomes written by hand."""

import json
from dataclasses import replace
from hashlib import sha256

import pytest
from click.testing import CliRunner, Result
from outcomes import ADDED, DIAGNOSIS, compared
from servo_pendulum import pendulum

import pyident as pi
from flexmodels.files.robot_file import load_robot, save_robot
from pyident.cli.main import main
from pyident.greybox.residual import Shown
from pyident.refinement.closed_loop import ClosedLoopFit
from pyident.verbs.fitted import ServoFit
from pyident.verbs.fmu.results import FmuDiagnosed
from pyident.verbs.judged import Added, Diagnosed


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Calls a command in an empty folder in which one verb answers at once; what the verb was asked."""
    monkeypatch.chdir(tmp_path)
    asked: dict = {}

    def call(verb: str, answer, *words: str) -> tuple[Result, dict]:
        def answered(*arguments, **named):
            asked.update(named, arguments=arguments)
            return answer

        getattr(pi, verb)
        monkeypatch.setattr(pi, verb, answered)
        return CliRunner().invoke(main, list(words)), asked

    return call


def test_something_missing_ends_in_1_with_page_draft_and_json(run, tmp_path):
    found = Diagnosed(replace(DIAGNOSIS, draft="LAW = 1\n"), ("a note",))
    words = ["-o", "page.html", "--draft", "law.py", "--json", "found.json", "--holdout", "c.csv"]
    done, asked = run("diagnose", found, "diagnose", "four_link", "a.csv", "b.csv", *words)
    assert done.exit_code == 1
    assert asked["arguments"] == ("four_link", ("a.csv", "b.csv"))
    assert (asked["heldout"], asked["draft"]) == (("c.csv",), True)
    for line in ("note: a note", "stribeck at joint1 is missing.", "wrote page.html", "wrote law.py"):
        assert line in done.output
    assert (tmp_path / "law.py").read_text() == "LAW = 1\n"
    assert "stribeck at joint1 is missing." in (tmp_path / "page.html").read_text("utf-8")
    assert json.loads((tmp_path / "found.json").read_text())["notes"] == ["a note"]


def test_nothing_missing_ends_in_0(run, tmp_path):
    nothing = replace(DIAGNOSIS, verdict="nothing_detectable", findings=(), sentence="Nothing is missing.")
    done, asked = run("diagnose", Diagnosed(nothing, ()), "diagnose", "four_link", "a.csv")
    assert done.exit_code == 0
    assert not asked["draft"]
    assert not list(tmp_path.iterdir())


def test_what_belongs_to_an_fmu_is_refused_with_a_robot(run):
    done, _ = run("diagnose", None, "diagnose", "four_link", "a.csv", "--parameters", "k")
    assert done.exit_code == 2
    assert "--parameters and --interface belong to an FMU as the model" in done.output


def test_what_is_known_of_a_drive_goes_to_every_judge(run):
    _, asked = run(
        "diagnose", Diagnosed(DIAGNOSIS, ()), "diagnose", "m.toml", "a.csv", "--set", "servo.kp=400"
    )
    assert asked["parameters"] == {"servo.kp": 400.0}
    words = ["add", "m.toml", "stribeck", "--joint", "1", "a.csv", "-o", "x.toml", "--set", "servo.kp=200"]
    _, asked = run("add_effect", Added(replace(ADDED, reason="no"), ()), *words)
    assert asked["parameters"] == {"servo.kp": 200.0}


def test_what_is_known_of_one_log_goes_with_that_log(run, tmp_path):
    save_robot(pendulum(), tmp_path / "stand.toml")
    fit = ServoFit(ClosedLoopFit(pendulum(), {}, None, ()), (), ())
    words = ["identify", str(tmp_path / "stand.toml"), "a.csv", "b.csv", "--set-in", "b.csv", "servo.kp=800"]
    _, asked = run("identify_servo", fit, *words)
    assert asked["settings"] == ({}, {"servo.kp": 800.0})
    done, _ = run("identify_servo", fit, *words[:-2], "c.csv", "servo.kp=800")
    assert done.exit_code == 2
    assert "--set-in c.csv servo.kp: it is none of the logs" in done.output


@pytest.mark.parametrize("verb", ["diagnose", "add"])
def test_a_parameter_that_is_fitted_cannot_be_set(tmp_path, verb):
    law = ["stribeck", "--joint", "1"] if verb == "add" else []
    words = [verb, "four_link", *law, "a.csv", "--set", "joint1.coulomb=1"]
    done = CliRunner().invoke(main, [*words, *(["-o", str(tmp_path / "x.toml")] if law else [])])
    assert done.exit_code == 2
    assert "joint1.coulomb is fitted to the logs, so no value can be set" in " ".join(done.output.split())


@pytest.mark.parametrize("reason", ["", "the error rises by 3 %"])
def test_a_law_is_written_or_refused(run, tmp_path, reason):
    answer = Added(replace(ADDED, reason=reason), ())
    words = ["add", "four_link", "stribeck", "--joint", "1", "a.csv", "-o", "new.toml"]
    done, asked = run("add_effect", answer, *words)
    assert done.exit_code == (1 if reason else 0)
    assert asked["arguments"] == ("four_link", "stribeck", 1, ("a.csv",))
    assert (tmp_path / "new.toml").is_file() == (not reason)
    assert (reason or "wrote new.toml") in done.output
    if not reason:
        assert "stribeck" in load_robot(tmp_path / "new.toml").joints[0].values


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("stribeck", "a.csv"), "where does stribeck act? Give --joint K, from 1"),
        (("stribeck", "--joint", "elbow", "a.csv"), "robot four_link has no joint elbow; its joints are"),
        (("geometry", "joint1.origin[z]"), "there is no log; give one or more behind joint1.origin[z]"),
        (("geometry", "joint9.origin[z]", "a.csv"), "robot four_link has no joint 9; it has 1 to 4"),
    ],
)
def test_what_add_lacks_is_said(run, words, sentence):
    done, _ = run("add_effect", None, "add", "four_link", *words, "-o", "new.toml")
    assert done.exit_code == 2
    assert sentence in done.output


def test_a_joint_goes_by_its_number_or_its_name(run):
    for joint in ("2", "joint2"):
        words = ("add", "four_link", "stribeck", "--joint", joint, "a.csv", "-o", "better.toml")
        _, asked = run("add_effect", ADDED, *words)
        assert asked["arguments"][1:3] == ("stribeck", 2)


def test_a_place_of_the_description_is_handed_on(run):
    words = ["add", "four_link", "geometry", "joint2.axis[y]", "a.csv", "b.csv", "-o", "new.toml"]
    _, asked = run("add_effect", Added(replace(ADDED, reason="no"), ()), *words)
    _, _, joint, logs = asked["arguments"]
    assert (joint, logs) == (2, ("a.csv", "b.csv"))


def test_two_models_are_compared_on_the_same_logs(run, tmp_path):
    words = ["compare", "four_link", "two.toml", "a.csv", "--json", "both.json"]
    done, asked = run("compare", compared(2.0), *words)
    assert done.exit_code == 0, done.output
    assert asked["arguments"] == ("two.toml", ["a.csv"])
    assert set(json.loads((tmp_path / "both.json").read_text())) >= {"old", "logs"}


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("a.csv", "four_link"), "a.csv is neither a shipped robot nor a .toml file; give the model first"),
        (("four_link",), "there is no log to compare with; give one or more behind the model"),
    ],
)
def test_a_comparison_of_nothing_is_refused(run, words, sentence):
    done, _ = run("compare", None, "compare", *words)
    assert done.exit_code == 2
    assert sentence in done.output


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--robust", "--refine"), "--robust is the estimator irls and --refine the estimator oe"),
        (("--set", "servo.kp=1"), "--set belongs to an FMU as the model, or to a robot with a [servo]"),
        (("--parameters", "k"), "--parameters and --interface belong to an FMU as the model"),
    ],
)
def test_options_that_exclude_each_other_are_refused(run, words, sentence):
    done, _ = run("identify", None, "identify", "four_link", "a.csv", *words)
    assert done.exit_code == 2
    assert sentence in " ".join(done.output.split())


@pytest.mark.parametrize(("white", "code"), [(0.5, 0), (1e-9, 1)])
def test_an_fmu_whose_residual_is_no_noise_ends_in_1(run, white, code):
    found = FmuDiagnosed("other", (Shown("y", "rad", 0.1, white, ()),), None, ("a note",))
    done, asked = run("diagnose_fmu", found, "diagnose", "other.fmu", "a.csv", "--json", "found.json")
    assert done.exit_code == code
    assert "note: a note" in done.output
    assert asked["arguments"][:2] == ("other.fmu", ("a.csv",))


def test_options_of_a_robot_are_refused_with_an_fmu(run):
    done, _ = run("diagnose_fmu", None, "diagnose", "other.fmu", "a.csv", "--holdout", "b.csv")
    assert done.exit_code == 2
    assert "--holdout" in done.output


def test_a_law_that_nobody_knows_is_refused():
    done = CliRunner().invoke(main, ["effects", "magic"])
    assert done.exit_code == 2
    assert "unknown effect 'magic'; known are asymmetric_coulomb" in done.output


def test_trust_is_in_the_content_of_a_file(tmp_path, monkeypatch):
    monkeypatch.setattr("flexmodels.effects.trust.user_config_path", lambda *_, **__: tmp_path / "config")
    (tmp_path / "laws.py").write_bytes(b"LAWS = []\n")
    done = CliRunner().invoke(main, ["trust", str(tmp_path / "laws.py")])
    assert done.exit_code == 0, done.output
    assert sha256(b"LAWS = []\n").hexdigest() in done.output
    done = CliRunner().invoke(main, ["trust", str(tmp_path / "none.py")])
    assert done.exit_code == 2
