"""Where the tools come from: pip, in environments that are not the project's own, or a compiler.

What is no Python package is built once from the sources in $FMI_SOURCES into the tools' folder.
"""

import fcntl
import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import venv
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

SOURCES = Path(os.environ.get("FMI_SOURCES", Path(__file__).parents[3] / "shared" / "fmi"))


class CannotInstall(RuntimeError):
    """A tool could not be installed or built; the message says what is missing."""


def cache_folder() -> Path:
    return Path(os.environ.get("FLEXIDENT_TOOL_ENVS", "~/.cache/flexident-tools")).expanduser()


@cache
def scripts_of(requirements: str) -> Path:
    """Folder of the executables of an environment that has the requirements, made at the first call."""
    key = hashlib.sha256(f"{sys.version} {requirements}".encode()).hexdigest()[:8]
    folder = cache_folder() / f"{requirements.split('=')[0]}-{key}"
    scripts = folder / ("Scripts" if sys.platform == "win32" else "bin")
    complete = folder / "complete"
    with _alone(folder):
        if complete.exists():
            return scripts
        venv.create(folder, clear=True, with_pip=True)
        pip = [str(scripts / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        done = subprocess.run([*pip, *requirements.split()], capture_output=True, text=True)
        if done.returncode:
            reason = (done.stderr.strip() or "pip failed").splitlines()[-1]
            raise CannotInstall(f"pip cannot install {requirements}: {reason}")
        complete.write_text(requirements)
    return scripts


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """One test process at a time makes what is missing in a folder."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with folder.with_name(f"{folder.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@cache
def fmilibrary() -> Path:
    """The shared library of FMILibrary 3, by CMake with its own zlib and expat."""
    folder = cache_folder() / "fmilibrary"
    built = folder / "build" / "libfmilib_shared.so"
    with _alone(folder):
        if built.exists():
            return built
        source = _unpacked("fmi-library", folder)
        off = ["-DFMILIB_GENERATE_DOXYGEN_DOC=OFF", "-DFMILIB_BUILD_TESTS=OFF"]
        _say(["cmake", "-S", source, "-B", built.parent, *off, "-DCMAKE_BUILD_TYPE=Release"])
        _say(["cmake", "--build", built.parent, "--target", "fmilib_shared"])
    return built


@cache
def fmusim() -> Path:
    """fmusim with libxml2, zlib and SUNDIALS 6 of the system (or of CPATH and LIBRARY_PATH)."""
    folder = cache_folder() / "fmusim"
    built = folder / "fmusim"
    with _alone(folder):
        if built.exists():
            return built
        root = _unpacked("Reference-FMUs", folder)
        zips = next(_unpacked("fmi-library", folder).glob("ThirdParty/Zlib/*/contrib/minizip"))
        parts = ["FMI", "FMI1", "FMI2", "FMI3", "structured_variable_name.yy", "structured_variable_name.tab"]
        sources = [*sorted((root / "fmusim").glob("*.c")), *(root / f"src/{part}.c" for part in parts)]
        sources += [zips / "ioapi.c", zips / "unzip.c"]
        include = [f"-I{path}" for path in (root / "fmusim", root / "include", "/usr/include/libxml2", zips)]
        names = ["cvode", "nvecserial", "sunlinsoldense", "sunmatrixdense", "generic"]
        static = ["-Wl,-Bstatic", *(f"-lsundials_{name}" for name in names), "-Wl,-Bdynamic"]
        words = ["-O2", "-w", '-DFMUSIM_VERSION="0"', "-DSUN_COMM_NULL=NULL", *include]
        _say(["gcc", *words, *sources, "-o", built, "-lxml2", "-lz", *static, "-ldl", "-lm"])
    return built


def _unpacked(name: str, folder: Path) -> Path:
    archive = SOURCES / f"{name}.tar.xz"
    if not archive.is_file():
        raise CannotInstall(f"{archive} is not here: set FMI_SOURCES to the folder of the sources")
    if not (folder / name).is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        with tarfile.open(archive) as tar:
            tar.extractall(folder, filter="data")
    return folder / name


def _say(command: list) -> None:
    words = list(map(str, command))
    if shutil.which(words[0]) is None:
        raise CannotInstall(f"{words[0]} is not here")
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        wrong = [line for line in done.stderr.splitlines() if "error" in line.lower()] or ["it failed"]
        raise CannotInstall(f"{words[0]} could not build a tool: {wrong[0]}")
