"""Results of two versions of the code are never taken for one another's."""

from pyident.sweep.code_version import code_version


def test_the_version_tells_settings_and_a_studys_own_files_apart(tmp_path):
    own = tmp_path / "study.py"
    own.write_text("1")
    first = code_version(own=[own])
    assert first == code_version(own=[own])
    own.write_text("2")
    assert len({first, code_version(own=[own]), code_version("a", own=[own]), code_version()}) == 4
