"""Any bytes as a planned motion or an FMU: exit code 0, 1 or 2, a sentence, and nothing else changes."""

import io
import zipfile
from pathlib import Path

import pytest
from hostile_files import changed_bytes, changed_xml, tables
from hostile_run import MANY, cleared, tried
from hypothesis import given
from hypothesis import strategies as st
from test_foreign_fmu import DESCRIPTION

ROBOT = (Path(__file__).parents[1] / "robots" / "two_link.toml").read_bytes()
PLAN = b"time,joint1.r,joint2.r\n" + b"\n".join(b"%g,%g,0" % (0.004 * i, i % 7) for i in range(20))
LOG = b"time,joint1.r,joint1.e\n" + b"\n".join(b"%g,%g,0" % (0.004 * i, i % 7) for i in range(20))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@MANY
@given(content=tables(["time", "joint1.r", "joint2.r"]) | changed_bytes(PLAN))
def test_planned_motions(content, folder):
    words = ("plan", "export", "plan.csv", "arm.toml", "-o", "out.yaml")
    done = tried("planned motions", folder, {"arm.toml": ROBOT, "plan.csv": content}, *words)
    assert (folder / "out.yaml").exists() == (done.exit_code != 2)
    cleared(folder)


@st.composite
def fmus(draw):
    """An archive with a description that is almost right, and no binary; sometimes with bytes changed."""
    sink = io.BytesIO()
    with zipfile.ZipFile(sink, "w") as archive:
        archive.writestr("modelDescription.xml", draw(changed_xml(DESCRIPTION)))
    return draw(changed_bytes(sink.getvalue())) if draw(st.integers(0, 2)) == 0 else sink.getvalue()


@MANY
@given(content=fmus())
def test_fmus_of_any_description(content, folder):
    """Nothing can be identified without a binary."""
    words = ("identify", "other.fmu", "log.csv", "--json", "out.json", "--parameters", "k")
    done = tried("FMUs", folder, {"other.fmu": content, "log.csv": LOG}, *words)
    assert done.exit_code == 2
    assert not (folder / "out.json").exists()
