"""Equations -> FMU file: generate, compile, zip."""

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from importlib.util import find_spec
from pathlib import Path

from flexfmu.description import identifier, model_description
from flexfmu.source import RUNTIME, model_sources, token_of
from flexmodels.atomic import replacing
from flexmodels.plant import Equations

_SOURCES = ["model.c", "plant.c", "fmi2.c"]


class BuildError(RuntimeError):
    """The FMU could not be compiled; the message says why and how to mend it."""


def export_fmu(equations: Equations, path: str | Path) -> Path:
    """Write an FMI 2.0 co-simulation FMU for this platform. Raises BuildError."""
    path = Path(path)
    generated = model_sources(equations)
    name = identifier(equations)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        sources = root / "sources"
        shutil.copytree(RUNTIME, sources, ignore=shutil.ignore_patterns("__pycache__"))
        for file, text in generated.items():
            (sources / file).write_text(text)
        binary = root / "binaries" / _platform() / f"{name}{_suffix()}"
        binary.parent.mkdir(parents=True)
        compile_shared(sources, _SOURCES, binary)
        xml = model_description(equations, token_of(generated), _SOURCES)
        (root / "modelDescription.xml").write_bytes(xml)
        _zip(root, path)
    return path


def compile_shared(folder: Path, sources: list[str], target: Path) -> None:
    """Compile the C files of a folder into a shared library."""
    flags = ["-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off"]
    if sys.platform != "win32":
        flags.append("-fPIC")
    command = [*compiler(), *flags, *sources, "-o", str(target), "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"the C compiler failed ({' '.join(command[:3])} ...):\n{done.stderr.strip()}")


def compiler() -> list[str]:
    """The C compiler: $CC, else cc, gcc or clang, else zig from the package ziglang."""
    if os.environ.get("CC"):
        return os.environ["CC"].split()
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    if find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    raise BuildError("no C compiler was found; install one with: pip install 'flexident[compiler]'")


def _platform() -> str:
    """FMI 2.0's name of this platform."""
    system = {"linux": "linux", "darwin": "darwin", "win32": "win"}.get(sys.platform, sys.platform)
    bits = "64" if sys.maxsize > 2**32 else "32"
    if platform.machine() not in ("x86_64", "AMD64"):
        return f"{platform.machine()}-{system}"
    return system + bits


def _suffix() -> str:
    return {"darwin": ".dylib", "win32": ".dll"}.get(sys.platform, ".so")


def _zip(folder: Path, path: Path) -> None:
    with replacing(path) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for member in sorted(folder.rglob("*")):
            if member.is_file():
                archive.write(member, member.relative_to(folder).as_posix())
