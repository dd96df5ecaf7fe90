"""Where a model fails, beside its floor: the true model, a hidden law, a measured axis, the page."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from two_link_logs import hidden, in_process, loaded, made_log, two_link

from flexmodels.files.robot_file import load_robot, save_robot
from pyident.cli.main import main
from pyident.comparison.compare import compare
from pyident.estimation.identify import identify
from pyident.logs.log import read_log, write_log
from pyident.report.comparison import write_comparison
from pyident.rules.comparison import ComparisonRules
from pyident.rules.rules import Rules
from pyident.verbs import judge

FEW = Rules(comparison=ComparisonRules(replicas=3))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("compare")


@pytest.fixture(scope="module")
def logs(folder):
    """Of the robot itself and of the one with a hidden law."""
    found = []
    for robot in (two_link(), hidden()):
        with loaded(robot, folder) as fmu:
            found.append(made_log(fmu, robot, 1))
    return found


@pytest.fixture(scope="module")
def found(folder, logs):
    return [compare(two_link(), [log], in_process, lambda _: None) for log in logs]


def test_the_true_model_is_at_its_floor(found):
    true = found[0]
    assert true.where is None
    assert true.sentence.startswith("Nothing stands out")
    for name, error in true.logs[0].equations.items():
        assert error.ratio == pytest.approx(1.0, abs=0.15), name
    for name, error in true.logs[0].simulation.items():
        assert 0.3 < error.ratio < 2.0, name


def test_a_hidden_law_is_found_where_it_is(found):
    where = found[1].where
    assert (where.joint, where.balance) == ("joint2", "motor")
    assert where.ratio > 5
    assert found[1].structural
    assert "joint 2, motor side" in found[1].sentence
    assert found[1].logs[0].equations["joint2.e"].ratio > 2


def test_errors_are_those_of_their_definition(found, logs):
    """rmse and percent of the logged torque, from first principles."""
    missed = found[1].logs[0].missed["joint2.e"]
    error = found[1].logs[0].simulation["joint2.e"]
    signal = logs[1].frame["joint2.e"].to_numpy()
    assert error.rmse == pytest.approx(np.sqrt(np.mean(missed**2)))
    assert error.nrmse_percent == pytest.approx(100 * np.linalg.norm(missed) / np.linalg.norm(signal))


def test_json_and_page(found, tmp_path):
    content = json.loads(json.dumps(found[1].json()))
    log = content["logs"]["log 1"]
    assert set(log["torque"]["joint1"]) >= {"rmse", "nrmse_percent", "floor_percent"}
    assert log["simulation"]["tip_rmse_m"] > 0
    assert set(log["simulation"]["e_rmse"]) == {"joint1", "joint2"}
    page = write_comparison(tmp_path / "page.html", ["old", "new"], found[::-1]).read_text("utf-8")
    assert "joint 2, motor side" in page
    assert "<script src=" not in page
    assert "Plotly.newPlot" in page
    assert len(page.encode()) < 2_000_000


def test_wrong_values_are_told_from_a_wrong_structure(folder, logs):
    stiff = {"joint1.k[1]": 0.9 * two_link().parameters["joint1.k[1]"]}
    c = compare(two_link().with_parameters(stiff), [logs[0]], in_process, lambda _: None)
    assert not c.structural
    assert "joint 1" in c.sentence
    assert c.where is not None
    assert c.where.balance == "transmission"


def test_a_measured_axis_without_controller(data, folder):
    robot = load_robot("emps")
    log = read_log(data / "emps" / "DATA_EMPS.mat", robot.settings.columns)
    fitted = identify(robot, [log])
    c = compare(fitted.robot, [log], in_process, lambda _: None, FEW)
    error = c.logs[0].equations["joint1.e"]
    assert 0.95 < error.nrmse_percent / fitted.relative_error["joint1"] < 1  # without the encoder's noise
    assert c.tracks
    assert c.logs[0].simulation["joint1.tau"].ratio > 1


def test_the_command(monkeypatch, folder, logs, tmp_path):
    monkeypatch.setattr(judge, "FmuRuns", in_process)
    write_log(logs[1], tmp_path / "log.parquet")
    save_robot(replace(two_link(), name="old"), tmp_path / "old.toml")
    words = ["compare", tmp_path / "old.toml", tmp_path / "log.parquet", "--json", tmp_path / "c.json"]
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    assert "joint 2, motor side" in done.output
    assert json.loads((tmp_path / "c.json").read_text())["where"]["joint"] == "joint2"


def test_bad_input(tmp_path):
    for words, said in (
        (["log.csv"], "log.csv is neither a shipped robot nor a .toml file"),
        (["four_link"], "there is no log to compare with"),
        (["four_link", "nowhere.csv"], "there is no log nowhere.csv"),
    ):
        done = CliRunner().invoke(main, ["compare", *words])
        assert done.exit_code == 2
        assert said in done.stderr
