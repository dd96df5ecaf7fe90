"""Text from files stays text: in C, XML, Modelica, pages and terminals, under names that any tool reads."""

import re
import tomllib
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import tomli_w
from hostile_run import MANY, cleared, counted, run, tried
from hypothesis import given, settings
from hypothesis import strategies as st

import pyident as pi
from flexfmu.build import export_fmu
from flexfmu.names import c_identifier
from flexmodels.mechanics.plant import equations
from pyident.report.interactive import in_script

ROBOT = tomllib.loads((Path(__file__).parents[1] / "robots" / "two_link.toml").read_text(encoding="utf-8"))
RUNS = '*/ __attribute__((constructor)) static void f(void) { fclose(fopen("ran", "w")); } /*'
NASTY = [
    RUNS,
    '"); system("touch ran"); ("',
    "</script><script>alert(1)</script>",
    "<!--<script>",
    "'\"><img src=x onerror=alert(1)>",
    '"; end x; model y "',
    "$(touch ran)`touch ran`; touch ran",
    "../../../etc/passwd",
    "]]>&amp;<!ENTITY",
    "${7*7}{{7*7}}{plot_id}%n%s\\",
    "??/",
    "#include",
    "model",
    "7 Zwerge – Größe",
    "\u202e\u0430rm",
    "CON",
    "",
]
TEXTS = st.sampled_from(NASTY) | st.text(max_size=40)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def named(texts):
    """The robot file with these texts in every place that takes one."""
    name, description, joint, column = texts
    joints = [row | {"name": f"{joint}{k}"} for k, row in enumerate(ROBOT["joint"])]
    columns = {"joint1.e": {"source": column, "gain": 1.0}}
    content = ROBOT | {"name": name, "description": description, "joint": joints, "columns": columns}
    return tomli_w.dumps(content).encode("utf-8", "surrogatepass")


@MANY
@given(texts=st.tuples(TEXTS, TEXTS, TEXTS, TEXTS), ending=st.sampled_from(["urdf", "xml", "json"]))
def test_robots_for_other_simulators(texts, ending, folder):
    words = ("robots", "export", "arm.toml", "-o", f"out.{ending}")
    done = tried("texts", folder, {"arm.toml": named(texts)}, *words)
    if done.exit_code == 0 and ending != "json":
        root = ET.parse(folder / f"out.{ending}").getroot()
        assert root.get("name", root.get("model")) == texts[0]
        assert {e.tag for e in root.iter()}.isdisjoint({"script", "img"})
    cleared(folder)


def test_names_are_identifiers_of_their_own():
    identifiers = [c_identifier(name) for name in NASTY]
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name, re.ASCII) for name in identifiers)
    assert len({name.lower() for name in identifiers}) == len(NASTY)


@pytest.mark.parametrize("name", NASTY)
def test_modelica_texts(name, folder):
    pymoca = pytest.importorskip("pymoca.parser")
    (folder / "arm.toml").write_bytes(named((name, name, name, name)))
    done = run("export", "arm.toml", "-o", "out.mo")
    counted("texts")
    assert done.exit_code == 0 or "printable text" in done.output
    if done.exit_code == 0:
        tree = pymoca.parse((folder / "out.mo").read_text(encoding="utf-8"))
        types = {"Real", "Integer", "Boolean", "String", "StateSelect", "Clock"}
        (package,) = (part for title, part in tree.classes.items() if title not in types)
        assert {"Arm", "Run"} <= set(package.classes)
        assert "y" not in package.classes


@pytest.mark.parametrize("name", [RUNS, "]]>&amp;<!ENTITY", "../../../etc/passwd"])
def test_system_structures(name, folder):
    (folder / "arm.toml").write_bytes(named((name,) * 4))
    assert run("export", "arm.toml", "-o", "out.ssp").exit_code == 0
    counted("texts")
    with zipfile.ZipFile(folder / "out.ssp") as archive:
        system = ET.fromstring(archive.read("SystemStructure.ssd"))
        names = ["SystemStructure.ssd", "resources/controller.fmu", "resources/plant.fmu"]
        assert archive.namelist() == names
    assert system.get("name") == name
    assert {path.name for path in folder.iterdir()} == {"arm.toml", "out.ssp"}


def test_an_fmu_runs_no_text(folder):
    """Compiled and loaded; the sources that it carries are the same for any text."""
    (folder / "arm.toml").write_bytes(named((RUNS,) * 4))
    robot = pi.load_robot(folder / "arm.toml")
    sources = []
    for fmi in (2, 3):
        path = export_fmu(equations(robot), folder / "out.fmu", fmi=fmi)
        with zipfile.ZipFile(path) as archive:
            described = ET.fromstring(archive.read("modelDescription.xml"))
            sources += [archive.read(name) for name in archive.namelist() if "/model" in name]
        assert described.get("modelName") == RUNS
        (identifier,) = (part.attrib["modelIdentifier"] for part in described.iterfind("CoSimulation"))
        assert re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", identifier, re.ASCII)
    assert sources
    for source in sources:
        strings = re.sub(rb'"(?:[^"\\]|\\.)*"', b"", source)
        assert b"fopen" not in strings
        assert b"__attribute__((constructor))" not in strings
    assert not (folder / "ran").exists()


@settings(parent=MANY)
@given(text=TEXTS)
def test_a_script_takes_any_text(text):
    """A browser leaves a script, or hides what follows it, only at a `<`."""
    assert "<" not in in_script({text: [text]})
