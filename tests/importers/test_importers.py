"""The exported FMU in other people's tools: they run it, check it, compile it.

Each tool runs 0.5 s of the paper's identification experiment in closed loop and must find the tip where our
own co-simulation (flexfmu.simulate) finds it.

Sampled inputs. A sample of the FMU's controller that is due at a communication point is taken at the
beginning of the next step, with the inputs that the tool sets there: every tool runs the plan as it is. In
model exchange the sample is a time event.

Tools that need an environment get one in $FLEXIDENT_TOOL_ENVS (default ~/.cache/flexident-tools).
"""

import re
import shutil
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from importers.environment import CannotInstall, scripts_of
from importers.matrix import SYSTEM_TOOLS, system_request, system_rows
from importers.tools import EXACT, FMPY, TOOLS, Tool, ask, say
from lxml import etree  # pyright: ignore[reportAttributeAccessIssue]

from flexfmu.simulate import LoadedFmu
from flexfmu.ssp import export_ssp
from flexmodels.experiment import Experiment, identification
from flexmodels.mechanics.plant import equations

pytestmark = pytest.mark.importers

HERE = Path(__file__).parent
SCHEMAS = Path(fmpy.__file__).parent / "schema"
TIP = ["tip.x", "tip.y", "tip.z"]
FMUTOOL = "fmu-manipulation-toolbox==2.0"
RUNS = [pytest.param(tool, v, id=f"{name}-fmi{v}") for name, tool in TOOLS.items() for v in tool.versions]
VERSIONS = pytest.mark.parametrize("version", [2, 3], ids=["fmi2", "fmi3"])


@pytest.fixture(scope="module")
def plan(four_link):
    return identification(four_link, duration=0.5)


@pytest.fixture(scope="module")
def own(four_link_fmu, plan):
    """Our own log of the plan."""
    with LoadedFmu(four_link_fmu) as loaded:
        return loaded.simulate(plan)


def scripts(requirement: str) -> Path:
    try:
        return scripts_of(requirement)
    except CannotInstall as reason:
        pytest.skip(str(reason))


def asked(tool: Tool, folder: Path, fmu: Path, plan: Experiment, **further) -> dict[str, np.ndarray]:
    """The answer of a tool's script, which must have nothing unknown to complain of."""
    pairs = (("r", plan.reference), ("tau_ff", plan.feedforward))
    request = {
        "fmu": str(fmu),
        "time": plan.time.tolist(),
        "inputs": {f"joint{k}.{s}": v.tolist() for s, u in pairs for k, v in enumerate(u.T, start=1)},
        "outputs": TIP,
    }
    try:
        answer = ask(tool, folder, request | further)
    except CannotInstall as reason:
        pytest.skip(str(reason))
    known = tool.expected or "(?!)"
    assert [line for line in answer.complaints if not re.search(known, line)] == []
    return dict(answer.rows)


def tip(table) -> np.ndarray:
    return np.column_stack([table[name] for name in TIP])


@pytest.mark.parametrize(("tool", "version"), RUNS)
def test_the_closed_loop_runs_alike(tool, version, fmus, plan, own, tmp_path):
    """Same inputs at the controller's samples (see the top of this file), same tip."""
    answer = asked(tool, tmp_path, fmus[version], plan)
    expected = tip(own)[1:]
    assert np.ptp(expected, axis=0).max() > 0.1  # it moves [m]
    np.testing.assert_allclose(tip(answer), expected, rtol=0, atol=tool.tolerance)


@VERSIONS
def test_casadi_finds_tip_and_derivatives(version, fmus, four_link, plan, own, tmp_path):
    """CasADi cannot run a sampled controller; it evaluates at the logged states, inputs play no part."""
    events = "(Next event time|Values of continuous states) not implemented"
    tool = Tool("CasADi", "run_casadi.py", "ModelExchange", EXACT, expected=events)
    states = {name: own[name].tolist() for name in four_link.coordinates}
    answer = asked(tool, tmp_path, fmus[version], plan, states=states)
    np.testing.assert_allclose(tip(answer), tip(own)[1:], rtol=0, atol=tool.tolerance)
    size = np.abs(answer["jacobian"]).max()
    np.testing.assert_allclose(answer["jacobian"], answer["differences"], atol=1e-9 * size)
    np.testing.assert_allclose(answer["adjoint"], answer["adjoint expected"], atol=1e-12 * size)


@VERSIONS
def test_the_sources_compile_elsewhere(version, fmus, plan, own, tmp_path):
    """`fmpy compile` builds the FMU from nothing but its sources and their description."""
    if not (shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")):
        pytest.skip("CMake needs a C compiler")
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(fmus[version]) as full, zipfile.ZipFile(bare, "w") as archive:
        for name in full.namelist():
            if not name.startswith("binaries/"):
                archive.writestr(name, full.read(name))
    said = say([sys.executable, "-m", "fmpy", "compile", bare])
    assert "warning" not in said.lower()
    answer = asked(FMPY, tmp_path, bare, plan)
    np.testing.assert_allclose(tip(answer), tip(own)[1:], rtol=0, atol=1e-9)  # another optimisation


def schema_errors(version, fmu):
    """XML file in the FMU -> what FMI's own schemas, which FMPy ships, find wrong with it."""
    schemas = {
        "modelDescription.xml": f"fmi{version}/fmi{version}ModelDescription.xsd",
        "sources/buildDescription.xml": "fmi3/fmi3BuildDescription.xsd",
        "terminalsAndIcons/terminalsAndIcons.xml": "fmi3/fmi3TerminalsAndIcons.xsd",
    }
    found = {}
    with zipfile.ZipFile(fmu) as archive:
        for name in (name for name in archive.namelist() if name.endswith(".xml")):
            schema = etree.XMLSchema(etree.parse(SCHEMAS / schemas[name]))
            schema.validate(etree.fromstring(archive.read(name)))
            found[name] = [str(error) for error in schema.error_log]
    return found


def fmpy_says(fmu):
    return say([sys.executable, "-m", "fmpy", "validate", fmu]).strip()


def fmutool_says(version, fmu):
    """The schema and, beyond it, the standard's rules on variables and the model structure: what it finds
    wrong, and its verdict."""
    said = say([scripts(FMUTOOL) / "fmutool", "-input", fmu, "-check"])
    wrong = [line for line in said.splitlines() if line.startswith(("WARNING", "ERROR", "CRITICAL"))]
    return wrong, f"No semantic error against the FMI-{version} standard" in said


@VERSIONS
def test_the_fmu_obeys_the_schemas(version, fmus):
    names = {"modelDescription.xml"}
    if version == 3:
        names |= {"sources/buildDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml"}
    assert schema_errors(version, fmus[version]) == {name: [] for name in names}


@VERSIONS
def test_fmpy_finds_no_problem(version, fmus):
    assert fmpy_says(fmus[version]) == "No problems found."


@VERSIONS
def test_fmutool_finds_no_problem(version, fmus):
    assert fmutool_says(version, fmus[version]) == ([], True)


@pytest.mark.parametrize("name", SYSTEM_TOOLS)
@pytest.mark.parametrize("parts", [1, 4])
def test_the_ssp_stays_stable_under_a_parallel_master(parts, name, four_link, four_link_fmu, tmp_path):
    """2 s at 4 and 1 ms; without the law's stiffness and damping it left the finite numbers at 4 ms."""
    plan = identification(four_link, duration=2.0)
    ssp = export_ssp(equations(four_link), tmp_path / "arm.ssp")
    try:
        answer = ask(TOOLS[name], tmp_path, system_request(ssp, plan, parts))
    except CannotInstall as reason:
        pytest.skip(str(reason))
    with LoadedFmu(four_link_fmu) as loaded:
        expected = tip(loaded.simulate(plan))[1:]
    assert answer.complaints == ()
    error = np.abs(system_rows(answer, parts) - expected).max()
    assert error < 3e-3 / parts  # [m], the tip moves by 1.5 m


@pytest.mark.parametrize("part", ["plant", "controller"])
def test_the_parts_of_an_ssp_pass_too(part, four_link, tmp_path_factory):
    """Schema, FMPy's validation and fmutool's rules for plant and controller as FMUs of their own."""
    folder = tmp_path_factory.mktemp("parts")
    with zipfile.ZipFile(export_ssp(equations(four_link), folder / "arm.ssp")) as archive:
        archive.extractall(folder)
    fmu = folder / "resources" / f"{part}.fmu"
    assert schema_errors(2, fmu) == {"modelDescription.xml": []}
    assert fmpy_says(fmu) == "No problems found."
    assert fmutool_says(2, fmu) == ([], True)
