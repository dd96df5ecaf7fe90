"""The state that all pages share: what is open, what outlives a change, what is recorded."""

from types import SimpleNamespace
from typing import cast

import pytest

from pyident.workbench import work
from pyident.workbench.bench import Bench
from pyident.workbench.jobs import Job
from pyident.workbench.project import ProjectError, Version, open_project


@pytest.fixture
def bench(tmp_path):
    for name in ("a.parquet", "b.parquet", "robot.toml", "better.toml"):
        (tmp_path / name).write_text("")
    return Bench(open_project(tmp_path))


def ended(bench: Bench, what: str, result) -> None:
    """As if work on the present inputs had ended well."""
    bench._asked[what] = bench.inputs
    job = SimpleNamespace(running=False, state="done", result=result, title=what)
    bench.jobs[what] = cast(Job, job)
    bench.collect()


def test_places_open_for_exactly_the_inputs_that_were_checked(bench):
    ended(bench, "check", {"a.parquet": ["2500 samples"], "b.parquet": ["2500 samples"]})
    assert bench.sound
    bench.assign("b.parquet", "hold out")
    assert not bench.sound
    bench.assign("b.parquet", "fit")
    assert bench.sound


def test_a_refused_log_keeps_them_shut(bench):
    sentence = f"{work.REFUSED}joint 1 turns the other way"
    ended(bench, "check", {"a.parquet": ["2500 samples"], "b.parquet": [sentence]})
    assert not bench.sound


def test_a_version_that_an_added_law_makes_stays_open(bench):
    """Its logs passed their checks when it was made; a version that somebody chose has to pass its own."""
    ended(bench, "check", {"a.parquet": ["2500 samples"], "b.parquet": ["2500 samples"]})
    bench._take(Version("better.toml", "robot.toml", "stribeck at joint 1", "pyident add …"))
    assert bench.inputs.model.endswith("better.toml")
    assert bench.sound
    assert bench.project.commands[-1] == "pyident add …"


def test_a_refused_law_is_said_and_changes_nothing(bench):
    before = bench.project
    bench._pending = Version("x.toml", what="stribeck at joint 1")
    ended(bench, "add", work.Outcome("the error rises by 3 %", (), (0.0, -0.1)))
    assert bench.message == "stribeck at joint 1 was refused: the error rises by 3 %"
    assert bench.project == before


@pytest.mark.parametrize(("floor", "asked"), [(None, False), (object(), True)])
def test_laws_are_asked_where_the_model_could_be_simulated(bench, monkeypatch, floor, asked):
    begun = []
    monkeypatch.setattr(bench, "start", lambda what, *rest: begun.append(what))
    ended(bench, "compare", SimpleNamespace(comparison=SimpleNamespace(floor=floor)))
    assert begun == ["ask"] * asked


def test_a_mapping_is_written_once_and_used(bench):
    bench.use_mapping("[columns]\n")
    bench.use_mapping("[columns]\n# mended\n")
    assert bench.project.mapping == "mapping_2.toml"
    assert bench.inputs.mapping.endswith("mapping_2.toml")
    assert (bench.project.folder / "mapping.toml").read_text() == "[columns]\n"


def test_a_version_that_is_not_there_is_one_sentence(bench):
    with pytest.raises(ProjectError, match="there is no version 3"):
        bench.inputs_of(3)


def test_a_link_out_of_the_folder_is_not_read(tmp_path):
    inside, outside = tmp_path / "project", tmp_path / "secret.parquet"
    inside.mkdir()
    outside.write_text("")
    for name in ("a.parquet", "robot.toml"):
        (inside / name).write_text("")
    (inside / "b.parquet").symlink_to(outside)
    project = open_project(inside)
    assert (project.logs, project.strangers) == (["a.parquet"], ["b.parquet"])
    assert Bench(project).inputs.logs == (str((inside / "a.parquet").resolve()),)
