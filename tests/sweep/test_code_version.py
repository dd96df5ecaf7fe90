"""Results of two versions of the code are never taken for one another's."""

from pyident.sweep.code_version import code_version
from pyident.sweep.kept_results import keep, kept, write_json


def test_the_version_tells_settings_and_a_studys_own_files_apart(tmp_path):
    own = tmp_path / "study.py"
    own.write_text("1")
    first = code_version(own=[own])
    assert first == code_version(own=[own])
    own.write_text("2")
    assert len({first, code_version(own=[own]), code_version("a", own=[own]), code_version()}) == 4


def test_what_another_version_kept_is_not_found(tmp_path):
    file = tmp_path / "logs" / "one.json"
    assert kept(file, "mine") is None
    keep(file, "mine", {"p": [1.0, float("inf")]})
    assert kept(file, "mine") == {"p": [1.0, float("inf")]}
    assert kept(file, "yours") is None
    write_json(file, {"failure": "no version"})
    assert kept(file, "mine") is None
