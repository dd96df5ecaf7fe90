"""Which package, and which room of pyident, may import which."""

import ast
import re
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {"flexmodels": ROOT / "models", "flexfmu": ROOT / "fmu", "pyident": ROOT / "pyident"}
MAY_IMPORT = {"flexmodels": set(), "flexfmu": {"flexmodels"}, "pyident": {"flexmodels"}}
# Rooms of pyident from the ground up: each may import those before it, and itself.
ROOMS = (
    "rules",
    "logs",
    "conditioning",
    "kinematics",
    "regression",
    "estimation",
    "simulation",
    "refinement",
    "greybox",
    "checks",
    "inspection",
    "comparison",
    "excitation",
    "diagnosis",
    "extension",
    "report",
    "sweep",
    "verbs",
    "workbench",
    "cli",
)
# Where robot, FMU and identification are put together.
COMPOSERS = {"simulation", "sweep", "verbs", "cli"}
LONGEST = 300  # lines of a file
FULLEST = 15  # Python files in a folder


def imports(file: Path) -> set[str]:
    """Dotted names that a file imports, names imported from a package included."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def sources(package: str) -> list[Path]:
    return sorted((PACKAGES[package] / package).rglob("*.py"))


def room_of(file: Path) -> str:
    """The room a file of pyident stands in; empty for the front door itself."""
    parts = file.relative_to(PACKAGES["pyident"] / "pyident").parts
    return parts[0] if len(parts) > 1 else ""


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_import_only_what_they_may(package):
    for file in sources(package):
        allowed = MAY_IMPORT[package] | {package}
        if package == "pyident" and room_of(file) in COMPOSERS:
            allowed = set(PACKAGES)
        ours = {name.split(".")[0] for name in imports(file)} & set(PACKAGES)
        assert ours <= allowed, f"{file} imports {ours - allowed}"


def test_every_folder_of_pyident_is_a_room():
    folders = {p.name for p in (PACKAGES["pyident"] / "pyident").iterdir() if (p / "__init__.py").is_file()}
    assert folders == set(ROOMS)


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_only_rooms_below_it(room):
    below = {*ROOMS[: ROOMS.index(room) + 1]}
    for file in sources("pyident"):
        if room_of(file) == room:
            used = {name.split(".")[1] for name in imports(file) if name.startswith("pyident.")}
            assert used & set(ROOMS) <= below, f"{file} imports {sorted(used & set(ROOMS) - below)}"


def test_identification_never_sees_the_plants_dynamics():
    forbidden = ("flexmodels.mechanics.dynamics", "flexmodels.mechanics.plant")
    for file in sources("pyident"):
        if room_of(file) not in COMPOSERS:
            assert not [name for name in imports(file) if name.startswith(forbidden)], file


def test_the_newcomers_map_leads_to_files_that_are_there():
    text = (ROOT / "CONTRIBUTING.md").read_text()
    lines = [line for line in text.splitlines() if line.startswith("| ") and line.count("|") == 3]
    places = [place for line in lines[1:] for place in re.findall(r"`([^` ]+(?:/|\.py))`", line)]
    assert len(places) > 10
    start = ROOT / "pyident" / "pyident"
    tops = ("models/", "fmu/")
    missing = [p for p in places if not ((ROOT if p.startswith(tops) else start) / p).exists()]
    assert missing in ([], ["effect.py"])  # that one lies beside the folder named before it
    (order,) = re.findall(r"only rooms before it: ([a-z,\s]+) \(", text)
    assert re.split(r",\s+", order) == list(ROOMS)


def test_few_files_import_fmpy():
    users = [
        file.name
        for package in PACKAGES
        for file in sources(package)
        if any(name.split(".")[0] == "fmpy" for name in imports(file))
    ]
    assert sorted(users) == ["access.py", "by_fmpy.py", "fmu_file.py", "runs.py", "simulate.py"]


def test_no_utils_module():
    assert not [
        file for package in PACKAGES for file in sources(package) if file.stem in ("utils", "helpers")
    ]


@pytest.mark.parametrize("folder", [*PACKAGES, "studies"])
def test_files_are_short(folder):
    files = sorted((PACKAGES.get(folder, ROOT) / folder).rglob("*.py"))
    assert files
    assert not {file.name: n for file in files if (n := len(file.read_text().splitlines())) > LONGEST}


@pytest.mark.parametrize("tree", ["models", "fmu", "pyident", "studies", "tests", "benchmarks"])
def test_folders_are_small(tree):
    count = Counter(file.parent for file in (ROOT / tree).rglob("*.py"))
    assert count
    assert not {folder: n for folder, n in count.items() if n > FULLEST}


def test_no_two_test_files_have_one_name():
    count = Counter(file.name for file in (ROOT / "tests").rglob("test_*.py"))
    assert [name for name, number in count.items() if number > 1] == []
