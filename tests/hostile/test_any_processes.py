"""A sample of hostile files as a user gives them: to a process of its own, whose streams are looked at."""

import subprocess
import sys
from pathlib import Path

import pytest
from hostile_files import changed_bytes, changed_toml, changed_xml
from hostile_run import FULL, MANY, Surroundings, counted
from hypothesis import given, settings
from hypothesis import strategies as st

ROBOTS = Path(__file__).parents[1] / "robots"
ROBOT = (ROBOTS / "two_link.toml").read_text(encoding="utf-8")
ARM = (ROBOTS / "mjcf" / "arm.xml").read_text(encoding="utf-8")
LOG = b"time,joint1.e,joint1.tau\n" + b"\n".join(b"%g,%g,0" % (0.004 * i, i % 7) for i in range(40))
FILES = st.one_of(
    st.tuples(st.just("arm.toml"), changed_toml(ROBOT)),
    st.tuples(st.just("arm.xml"), changed_xml(ARM)),
    st.tuples(st.just("log.csv"), changed_bytes(LOG)),
)
WORDS = {
    "arm.toml": ("robots", "export", "arm.toml", "-o", "out.xml"),
    "arm.xml": ("robots", "import", "arm.xml", "-o", "out.toml"),
    "log.csv": ("log", "inspect", "log.csv"),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@settings(parent=MANY, max_examples=40 if FULL else 4)
@given(file=FILES)
def test_a_process_of_its_own(file, folder):
    name, content = file
    (folder / name).write_bytes(content)
    before = Surroundings(folder)
    words = [sys.executable, "-m", "pyident", *WORDS[name]]
    done = subprocess.run(words, capture_output=True, timeout=300, check=False)
    counted("files given to a process")
    said = done.stdout + done.stderr
    assert done.returncode in (0, 1, 2), said
    assert b"Traceback" not in said
    assert said.strip()
    assert before.changes(() if done.returncode == 2 else ("out.xml", "out.toml")) == []
    for output in folder.glob("out.*"):
        output.unlink()
