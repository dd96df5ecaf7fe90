"""The Reference-FMUs of the Modelica Association, compiled from their sources."""

import os
import shutil
import subprocess
import tarfile
import zipfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import pytest

SOURCES = Path(os.environ.get("FMI_SOURCES", Path(__file__).parents[3] / "shared" / "fmi"))


@cache
def _unpacked(folder: Path) -> Path:
    archive = next((f / "Reference-FMUs.tar.xz" for f in (SOURCES,) if f.is_dir()), None)
    if archive is None or not archive.is_file():
        pytest.skip("the sources of the Reference-FMUs are not here: set FMI_SOURCES to their folder")
    with tarfile.open(archive) as tar:
        tar.extractall(folder, filter="data")
    return folder / "Reference-FMUs"


def reference_fmu(name: str, fmi: int, folder: Path, edits: Sequence[tuple[str, str, str]] = ()) -> Path:
    """`name`.fmu for this machine, FMI 2 or 3; skips the test without sources or a C compiler.

    edits   file, what stands in it once, and what shall stand there
    """
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler")
    root = _unpacked(folder)
    for file, old, new in edits:
        text = (root / name / file).read_text()
        assert text.count(old) == 1, (file, old)
        (root / name / file).write_text(text.replace(old, new))
    binary = folder / f"{name}{fmi}.so"
    sources = [root / name / "model.c", root / f"src/fmi{fmi}Functions.c", root / "src/cosimulation.c"]
    flags = [
        "-shared",
        "-fPIC",
        "-O1",
        f"-DFMI_VERSION={fmi}",
        "-w",
        f"-I{root / 'include'}",
        f"-I{root / name}",
    ]
    flags += ["-DFMI3_OVERRIDE_FUNCTION_PREFIX"] if fmi == 3 else ["-DDISABLE_PREFIX"]
    subprocess.run([compiler, *flags, "-o", str(binary), *map(str, sources), "-lm"], check=True)
    path = folder / f"{name}_{fmi}.fmu"
    platform = "linux64" if fmi == 2 else "x86_64-linux"
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(root / name / f"FMI{fmi}.xml", "modelDescription.xml")
        archive.write(binary, f"binaries/{platform}/{name}.so")
    return path
