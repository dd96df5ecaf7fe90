"""`pyident study`: its table, what it writes, and how it ends."""

import json

import pytest
from click.testing import CliRunner

from pyident.cli.main import main
from pyident.sweep.studies import StudyResult, row


@pytest.fixture
def ran(monkeypatch, tmp_path):
    """Calls the command with a study of these rows: its result and the JSON file."""

    def run(*rows):
        def study(folder, progress):
            progress(1.0)
            (folder / "figure.png").write_bytes(b"")
            return StudyResult(list(rows), [folder / "figure.png"], ["a note"])

        monkeypatch.setattr("pyident.sweep.studies.find_study", lambda name: study)
        words = ["study", "mine", "-o", str(tmp_path), "--json", str(tmp_path / "rows.json")]
        done = CliRunner().invoke(main, words)
        return done, json.loads((tmp_path / "rows.json").read_text())

    return run


def test_goals_that_are_met_end_well(ran, tmp_path):
    done, rows = ran(row("error", "1 %", "2 %", True), row("seconds", "3"))
    assert done.exit_code == 0, done.output
    assert rows[0] == {"study": "mine", "what": "error", "value": "1 %", "goal": "2 %", "met": "yes"}
    assert rows[1]["met"] == "-"
    said = " ".join(done.output.split())
    assert "mine: a note" in said
    assert "figure.png" in said


def test_a_goal_that_is_not_met_is_exit_code_1(ran):
    done, rows = ran(row("error", "1 %", "2 %", True), row("bias", "3 %", "2 %", False))
    assert done.exit_code == 1
    assert [r["met"] for r in rows] == ["yes", "no"]


def test_a_study_that_is_not_there_runs_none(tmp_path):
    done = CliRunner().invoke(main, ["study", "paper", "nothing", "-o", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "there is no study nothing; there are" in done.output
    assert not (tmp_path / "out" / "paper").exists()
