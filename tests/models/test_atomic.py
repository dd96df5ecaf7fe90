"""A file is written whole or not at all."""

import pytest

from flexmodels.atomic import replacing


def _content(folder):
    return {file.name: file.read_text() for file in folder.iterdir()}


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    (tmp_path / "log.csv").write_text("old")

    def stops_half_way():
        with replacing(tmp_path / "log.csv") as file:
            file.write_text("half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        stops_half_way()
    assert _content(tmp_path) == {"log.csv": "old"}


def test_success_leaves_the_new_file_and_nothing_else(tmp_path):
    (tmp_path / "log.csv").write_text("old")
    with replacing(tmp_path / "log.csv") as file:
        assert file.suffix == ".csv"
        file.write_text("new")
        assert (tmp_path / "log.csv").read_text() == "old"
    assert _content(tmp_path) == {"log.csv": "new"}


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such folder"), replacing(tmp_path / "nowhere" / "x.csv"):
        pass
