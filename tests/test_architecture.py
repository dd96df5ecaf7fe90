"""Which package may import which."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {"flexmodels": ROOT / "models", "flexfmu": ROOT / "fmu", "pyident": ROOT / "pyident"}
MAY_IMPORT = {"flexmodels": set(), "flexfmu": {"flexmodels"}, "pyident": {"flexmodels"}}
# where robot, FMU and identification are put together
COMPOSERS = {
    "pyident/sweep/worker.py",
    "pyident/cli/main.py",
    "pyident/cli/shared.py",
    "pyident/sweep/run.py",
    "pyident/simulation/fmu_runs.py",
}


def imports(file: Path) -> set[str]:
    """Dotted names that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: relative import"
            found.add(node.module or "")
    return found


def sources(package: str) -> list[Path]:
    return sorted((PACKAGES[package] / package).rglob("*.py"))


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_import_only_what_they_may(package):
    for file in sources(package):
        allowed = MAY_IMPORT[package] | {package}
        if file.relative_to(PACKAGES[package]).as_posix() in COMPOSERS:
            allowed = set(PACKAGES)
        ours = {name.split(".")[0] for name in imports(file)} & set(PACKAGES)
        assert ours <= allowed, f"{file} imports {ours - allowed}"


def test_identification_never_sees_the_plants_dynamics():
    forbidden = {"flexmodels.mechanics.dynamics", "flexmodels.mechanics.plant"}
    for file in sources("pyident"):
        if file.relative_to(PACKAGES["pyident"]).as_posix() not in COMPOSERS:
            assert not imports(file) & forbidden, file


def test_only_one_file_imports_fmpy():
    users = [
        file.name
        for package in PACKAGES
        for file in sources(package)
        if any(name.split(".")[0] == "fmpy" for name in imports(file))
    ]
    assert users == ["simulate.py"]


def test_no_utils_module():
    assert not [
        file for package in PACKAGES for file in sources(package) if file.stem in ("utils", "helpers")
    ]
