"""A folder as a project: what it holds, what was chosen of it, and what it refuses."""

import json

import pytest

from pyident.workbench.project import STATE, ProjectError, Version, command, is_worth_opening, open_project


@pytest.fixture
def folder(tmp_path):
    for name in ("a.parquet", "b.csv", "robot.toml", "notes.txt", ".hidden.csv"):
        (tmp_path / name).write_text("")
    return tmp_path


def test_a_folder_lists_its_logs_and_models(folder):
    project = open_project(folder)
    assert project.logs == ["a.parquet", "b.csv"]
    assert project.models == ["robot.toml"]
    assert project.model == "robot.toml"


def test_a_studys_folder_opens_on_its_identified_robot(tmp_path):
    (tmp_path / "regression.toml").write_text("")
    (tmp_path / "identified.toml").write_text("")
    assert not is_worth_opening(tmp_path)
    (tmp_path / "identification.parquet").write_text("")
    assert is_worth_opening(tmp_path)
    assert open_project(tmp_path).model == "identified.toml"


def test_choices_survive_a_restart(folder):
    project = open_project(folder).having_role("b.csv", "hold out")
    project = project.extended(Version("better.toml", "robot.toml", "stribeck at joint 2", "…", (0.5, 0.25)))
    project.after(command("compare", "robot.toml", ["a.parquet"])).save()
    again = open_project(folder)
    assert again.with_role("fit") == ["a.parquet"]
    assert again.with_role("hold out") == ["b.csv"]
    assert again.model == "better.toml"
    assert again.versions[1].fall == (0.5, 0.25)
    assert again.commands == ("pyident compare robot.toml a.parquet",)


def test_a_version_after_an_undo_replaces_what_was_undone(folder):
    project = open_project(folder)
    for name in ("one.toml", "two.toml"):
        project = project.extended(Version(name))
    project = project.at_version(1).extended(Version("other.toml"))
    assert [v.model for v in project.versions] == ["robot.toml", "one.toml", "other.toml"]


@pytest.mark.parametrize("name", ["../secret.csv", "/etc/passwd", ".ssh", "a/b.csv", ".."])
def test_no_file_outside_the_folder_is_touched(folder, name):
    with pytest.raises(ProjectError, match="not a file of this project"):
        open_project(folder).path(name)


def test_a_link_out_of_the_folder_is_refused(folder, tmp_path_factory):
    secret = tmp_path_factory.mktemp("elsewhere") / "secret.csv"
    secret.write_text("1")
    (folder / "innocent.csv").symlink_to(secret)
    with pytest.raises(ProjectError):
        open_project(folder).path("innocent.csv")


@pytest.mark.parametrize("content", ["{", "[]", '{"versions": 3}', json.dumps({"mapping": ""})])
def test_a_damaged_state_is_one_sentence(folder, content):
    (folder / STATE).write_text(content)
    with pytest.raises(ProjectError, match="delete it to start afresh"):
        open_project(folder)


def test_commands_are_quoted_for_the_shell():
    assert (
        command("compare", "my arm.toml", ["a;rm -rf.csv"]) == "pyident compare 'my arm.toml' 'a;rm -rf.csv'"
    )
