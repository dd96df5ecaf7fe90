"""The cases of cases.toml: each ends with its sentence, in one line, and changes nothing around it."""

import os
import tomllib
from pathlib import Path

import pytest
from hostile_run import Surroundings, counted, fault, run

from flexmodels.files.robot_file import shipped

HERE = Path(__file__).parent
CASES = tomllib.loads((HERE / "cases.toml").read_text(encoding="utf-8"))["case"]
BASES = {**shipped(), "two_link": HERE.parent / "robots" / "two_link.toml"}


def lay_out(case, folder):
    """Write the files of a case."""
    for name, (base, changes) in case.get("base", {}).items():
        text = BASES[base].read_text(encoding="utf-8")
        for old, new in changes.items():
            assert old in text
            text = text.replace(old, new, 1)
        (folder / name).write_text(text, encoding="utf-8")
    for name, text in case.get("files", {}).items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(text.encode("latin-1"))
    for name, target in case.get("links", {}).items():
        os.symlink(folder / target, folder / name)


def in_folder(word, folder):
    return f"{folder}/{word[1:-1]}" if word.startswith("{") else word


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_case(case, tmp_path, monkeypatch):
    folder = tmp_path / "folder"
    folder.mkdir()
    monkeypatch.chdir(folder)
    lay_out(case, folder)
    before = Surroundings(folder)
    done = run(*(in_folder(word, folder) for word in case["words"]))
    counted("cases")
    assert fault(done) is None
    assert done.exit_code == case.get("code", 2), done.output
    assert case["says"] in " ".join(done.output.split())
    if done.exit_code == 2:
        assert len(done.output.strip().splitlines()) == 1
    assert before.changes(tuple(case.get("new", ()))) == []


def test_deep_nesting_and_endless_numbers(tmp_path):
    huge = BASES["two_link"].read_text().replace("m = ", "m = 1" + "0" * 400 + "\n#", 1)
    for name, text, words in (
        ("deep.toml", "a = " + "[" * 5000 + "]" * 5000, "not a TOML file"),
        ("long.toml", "a = " + "9" * 5000, "not a TOML file"),
        ("huge.toml", huge, "finite"),
    ):
        (tmp_path / name).write_text(text)
        done = run("identify", tmp_path / name, tmp_path / "log.csv")
        assert fault(done) is None
        assert done.exit_code == 2
        assert words in done.output


def chain(links, kind):
    """A URDF of links one behind the other."""
    parts = [f"<link name='l{i}'/>" for i in range(links)]
    parts += [
        f"<joint name='j{i}' type='{kind}'><parent link='l{i}'/><child link='l{i + 1}'/></joint>"
        for i in range(links - 2)
    ]
    last = links - 2
    parts.append(
        f"<joint name='j' type='continuous'><parent link='l{last}'/><child link='l{last + 1}'/></joint>"
    )
    return f"<robot name='chain'>{''.join(parts)}</robot>"


def test_a_urdf_of_1500_links(tmp_path):
    (tmp_path / "moving.urdf").write_text(chain(1500, "continuous"))
    done = run("robots", "import", tmp_path / "moving.urdf", "-o", tmp_path / "arm.toml")
    assert done.exit_code == 2
    assert "1499 joints move" in done.output
    assert not (tmp_path / "arm.toml").exists()
    (tmp_path / "fixed.urdf").write_text(chain(1500, "fixed"))
    done = run("robots", "import", tmp_path / "fixed.urdf", "-o", tmp_path / "arm.toml")
    assert done.exit_code == 0, done.output
    assert run("robots", "export", tmp_path / "arm.toml", "-o", tmp_path / "arm.urdf").exit_code == 0


def test_what_is_trusted_runs_until_it_changes(tmp_path):
    effects = tmp_path / "mine.py"
    effects.write_text(f"from pathlib import Path\nPath({str(tmp_path / 'ran')!r}).touch()\n")
    text = 'effects = ["mine.py"]\n' + BASES["two_link"].read_text()
    (tmp_path / "arm.toml").write_text(text)
    words = ("robots", "export", tmp_path / "arm.toml", "-o", tmp_path / "arm.urdf")
    assert "is Python code that would be run" in run(*words).output
    assert not (tmp_path / "ran").exists()
    assert run("trust", effects).exit_code == 0
    assert "defines no Effect" in run(*words).output
    assert (tmp_path / "ran").exists()
    (tmp_path / "ran").unlink()
    effects.write_text(effects.read_text() + "# changed\n")
    assert "is Python code that would be run" in run(*words).output
    assert not (tmp_path / "ran").exists()
