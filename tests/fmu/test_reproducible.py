"""Two exports of one model are the same file, byte by byte, also in other processes and at other times."""

import hashlib
import os
import subprocess
import sys
import time
import zipfile

import pytest

_EXPORT = """
import sys
import pyident as pi
pi.export_fmu(sys.argv[1], sys.argv[2], fmi=int(sys.argv[3]), part="plant")
"""


@pytest.fixture(scope="module")
def caches(tmp_path_factory):
    """Two folders for what the compiler made: nothing of one export is in the other."""
    return tmp_path_factory.mktemp("a"), tmp_path_factory.mktemp("b")


def exported(folder, fmi, hash_seed, cache, date=None):
    """One export in a process of its own; its path."""
    folder.mkdir()
    path = folder / "emps.fmu"
    environment = {k: v for k, v in os.environ.items() if k != "SOURCE_DATE_EPOCH"}
    environment |= {"PYTHONHASHSEED": hash_seed, "XDG_CACHE_HOME": str(cache)} | (
        {"SOURCE_DATE_EPOCH": date} if date else {}
    )
    subprocess.run([sys.executable, "-c", _EXPORT, "emps", str(path), str(fmi)], env=environment, check=True)
    return path


@pytest.mark.parametrize("fmi", [2, 3])
def test_two_exports_are_the_same_bytes(tmp_path, caches, fmi):
    first = exported(tmp_path / "a", fmi, "1", caches[0], "1700000000")
    time.sleep(2.1)  # the clock of a zip file has steps of two seconds
    second = exported(tmp_path / "b", fmi, "2", caches[1], "1700000000")
    with zipfile.ZipFile(first) as a, zipfile.ZipFile(second) as b:
        assert a.namelist() == b.namelist()
        different = [name for name in a.namelist() if a.read(name) != b.read(name)]
        assert not different
        assert b"2023-11-14T22:13:20Z" in a.read("modelDescription.xml")
    assert hashlib.sha256(first.read_bytes()).digest() == hashlib.sha256(second.read_bytes()).digest()


def test_the_date_is_the_only_difference(tmp_path, caches):
    """Another date changes the description alone; none leaves it out."""
    dated = exported(tmp_path / "a", 2, "1", caches[0], "1700000000")
    bare = exported(tmp_path / "b", 2, "1", caches[1])
    with zipfile.ZipFile(dated) as a, zipfile.ZipFile(bare) as b:
        different = [name for name in a.namelist() if a.read(name) != b.read(name)]
        assert different == ["modelDescription.xml"]
        assert b"generationDateAndTime" not in b.read("modelDescription.xml")
