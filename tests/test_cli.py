import json

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from flexmodels.files.robot_file import load_robot, shipped
from pyident.cli.main import COMMANDS, main
from pyident.logs.log import write_log


def run(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture
def log_file(identification_log, tmp_path):
    path = tmp_path / "log.csv"
    identification_log.frame.head(400).to_csv(path, index=False)
    return path


def test_lists():
    assert "four_link" in run("robots").output
    assert "coulomb" in run("effects").output
    assert "Armstrong" in run("effects", "stribeck").output


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_has_help_with_an_example(command):
    done = run(command, "--help")
    assert done.exit_code == 0
    assert "Example: pyident" in done.output


def test_export_simulate_identify(tmp_path):
    assert run("export", "four_link", "-o", tmp_path / "arm.fmu").exit_code == 0
    assert (tmp_path / "arm.fmu").stat().st_size > 10_000
    done = run("simulate", "four_link", "--experiment", "line", "-o", tmp_path / "line.csv")
    assert done.exit_code == 0
    again = run(
        "simulate", "four_link", "--experiment", tmp_path / "line.csv", "-o", tmp_path / "again.parquet"
    )
    assert again.exit_code == 0
    a, b = pd.read_csv(tmp_path / "line.csv"), pd.read_parquet(tmp_path / "again.parquet")
    np.testing.assert_allclose(a["tip.z"], b["tip.z"], atol=1e-9)


def test_identify_writes_robot_and_json(log_file, tmp_path):
    new, report = tmp_path / "new.toml", tmp_path / "new.json"
    done = run("identify", "four_link", log_file, "-o", new, "--json", report)
    assert done.exit_code == 0, done.output
    assert "relative torque error" in done.output
    content = json.loads(report.read_text())
    assert content["parameters"]["joint1.k[1]"]["unit"] == "N.m/rad"
    assert load_robot(new).parameters["joint1.k[1]"] == content["parameters"]["joint1.k[1]"]["value"]


def spoilt(name, frame):
    if name == "missing":
        return frame.drop(columns="joint3.tau")
    if name == "nan":
        return frame.assign(**{"joint2.e": frame["joint2.e"].where(frame.index != 5)})
    if name == "gap":
        return frame.drop(index=100)
    return frame.head(60)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing", "column joint3.tau is missing"),
        ("nan", "column joint2.e is not finite in 1 rows, first in row 6"),
        ("gap", "time goes from 0.396 s to 0.404 s"),
        ("short", "60 samples are too few"),
    ],
)
def test_bad_logs_end_in_one_sentence_and_exit_code_2(name, words, identification_log, tmp_path):
    path, new = tmp_path / "log.csv", tmp_path / "new.toml"
    spoilt(name, identification_log.frame.head(400)).to_csv(path, index=False)
    done = run("identify", "four_link", path, "-o", new)
    assert done.exit_code == 2
    assert words in done.output
    assert len(done.output.strip().splitlines()) == 1
    assert not new.exists()


def test_bad_robots_end_in_one_sentence_and_exit_code_2(log_file, tmp_path):
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(shipped()["four_link"].read_text().replace("m = 34.0", "m = -34.0"))
    for model, words in (
        ("nobody", "unknown robot 'nobody'"),
        (wrong, "link[1].m = -34.0 must be at least 0"),
    ):
        done = run("identify", model, log_file)
        assert done.exit_code == 2
        assert words in done.output
        assert len(done.output.strip().splitlines()) == 1


def test_a_robot_that_ships_is_copied_with_its_comments(tmp_path):
    copy = tmp_path / "my_arm.toml"
    assert run("robots", "copy", "four_link", "-o", copy).exit_code == 0
    assert copy.read_bytes() == shipped()["four_link"].read_bytes()
    done = run("robots", "copy", "nobody", "-o", tmp_path / "no.toml")
    assert (done.exit_code, "no robot nobody ships; there are emps, four_link" in done.output) == (2, True)


def test_a_folder_that_is_not_there(log_file, tmp_path):
    done = run("identify", "four_link", log_file, "-o", tmp_path / "nowhere" / "new.toml")
    assert done.exit_code == 2
    assert "nowhere: there is no such folder" in done.output


def test_an_fmu_can_take_the_plants_place(tmp_path):
    assert run("export", "four_link", "-o", tmp_path / "arm.fmu", "--fmi", "3").exit_code == 0
    assert run("simulate", "four_link", "--experiment", "line", "-o", tmp_path / "a.csv").exit_code == 0
    done = run("simulate", tmp_path / "arm.fmu", "--experiment", tmp_path / "a.csv", "-o", tmp_path / "b.csv")
    assert done.exit_code == 0, done.output
    a, b = pd.read_csv(tmp_path / "a.csv"), pd.read_csv(tmp_path / "b.csv")
    np.testing.assert_allclose(a["tip.z"], b["tip.z"], atol=1e-9)


def test_other_bad_input(tmp_path, identification_log):
    output = tmp_path / "x.csv"
    assert "no [controller]" in run("simulate", "emps", "--experiment", "line", "-o", output).output
    assert (
        "there is no log" in run("simulate", "four_link", "--experiment", "nothing.csv", "-o", output).output
    )
    write_log(identification_log, tmp_path / "log.csv")
    bare = pd.read_csv(tmp_path / "log.csv").drop(columns="joint2.r")
    bare.to_csv(tmp_path / "bare.csv", index=False)
    done = run("simulate", "four_link", "--experiment", tmp_path / "bare.csv", "-o", output)
    assert "column joint2.r is missing" in done.output
    assert "there is no study nothing" in run("study", "nothing").output
    assert not output.exists()
