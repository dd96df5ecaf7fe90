"""Objects that were compiled before are taken as they are, and only those."""

import hashlib

import pytest

from flexfmu.build import export_fmu
from flexfmu.code import compilation
from flexmodels.compiling import kept
from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics.plant import equations

FILES = {
    "one.c": '#include "one.h"\nint one(void) { return ONE; }\n',
    "two.c": "int two(void) { return 2; }\n",
    "one.h": '#include "deep.h"\n',
    "deep.h": "#define ONE 1\n",
}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    if tmp_path not in kept.cache_folder().parents:
        pytest.skip("the cache of this system is elsewhere")
    return kept.cache_folder() / "objects"


@pytest.fixture
def compiled(monkeypatch):
    """C files that the compiler was called for, in order."""
    called, run = [], compilation._run

    def listening(command, folder):
        called.extend(word for word in command if word.endswith(".c"))
        run(command, folder)

    monkeypatch.setattr(compilation, "_run", listening)
    return called


@pytest.fixture
def built(tmp_path, compiled):
    def build(**changes):
        folder, binary = tmp_path / "sources", tmp_path / "binary" / "both.so"
        for path in (folder, binary.parent):
            path.mkdir(exist_ok=True)
        for name, text in (FILES | {k.replace("_", "."): v for k, v in changes.items()}).items():
            (folder / name).write_text(text)
        compiled.clear()
        compilation.compile_for(compilation.HOST, folder, ["one.c", "two.c"], binary, native=True)
        return hashlib.sha256(binary.read_bytes()).hexdigest(), list(compiled)

    return build


def test_the_second_time_nothing_is_compiled_and_the_binary_is_the_same(built):
    first, both = built()
    again, none = built()
    assert sorted(both) == ["one.c", "two.c"]
    assert none == []
    assert again == first


def test_a_header_of_a_header_counts_and_for_those_alone_that_include_it(built):
    first, _ = built()
    other, again = built(deep_h="#define ONE 11\n")
    assert again == ["one.c"]
    assert other != first
    assert built() == (first, [])


def test_another_call_of_the_compiler_is_another_object(built, monkeypatch):
    built()
    monkeypatch.setattr(compilation, "_FLAGS", [*compilation._FLAGS, "-DMORE"])
    assert sorted(built()[1]) == ["one.c", "two.c"]


def test_a_damaged_object_is_compiled_anew(built, cache):
    first, _ = built()
    for file in cache.iterdir():
        file.write_bytes(file.read_bytes()[:-100])
    again, both = built()
    assert sorted(both) == ["one.c", "two.c"]
    assert again == first
    assert len(list(cache.iterdir())) == 2


def test_without_a_cache_everything_is_compiled(built, cache):
    cache.parent.parent.mkdir(parents=True, exist_ok=True)
    cache.parent.write_text("no folder")
    assert built()[0] == built()[0]
    assert sorted(built()[1]) == ["one.c", "two.c"]


def test_what_was_used_longest_ago_makes_room(built, cache, monkeypatch):
    built()
    monkeypatch.setattr(kept, "_LARGEST", sum(file.stat().st_size for file in cache.iterdir()) + 100)
    built(
        two_c="int two(void) { return 22; }\n"
    )  # takes one.c's object from the cache: the old two.c's is older
    assert len(list(cache.iterdir())) == 2
    assert built(two_c="int two(void) { return 22; }\n")[1] == []


def test_other_values_of_the_parameters_compile_their_table_alone(tmp_path, compiled):
    robot = load_robot("emps")
    export_fmu(equations(robot), tmp_path / "a.fmu", light=True)
    assert "model.c" in compiled
    compiled.clear()
    other = robot.with_parameters({name: 1.1 * value for name, value in robot.parameters.items()})
    export_fmu(equations(other), tmp_path / "b.fmu", light=True)
    assert set(compiled) == {"model_tables.c", "states.c", "fmi2.c"}
