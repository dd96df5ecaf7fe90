"""C source -> a library of this machine, compiled once and kept in the user's cache."""

import ctypes
import hashlib
import logging
import platform
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from platformdirs import user_cache_path

from flexmodels.atomic import replacing
from flexmodels.compiler import BuildError, compiler

# -ffast-math for sines of several samples at once; never given to the linker, where it changes the process.
_FLAGS = ["-std=c11", "-O3", "-march=native", "-ffast-math"]
_FLAGS += [] if sys.platform == "win32" else ["-fPIC"]
_SUFFIX = ".dll" if sys.platform == "win32" else ".so"
_log = logging.getLogger(__name__)


def library(source: str) -> ctypes.CDLL | None:
    """The compiled source; None where it cannot be compiled or loaded, with a note to the log."""
    try:
        command = compiler()
        path = cache_folder() / f"{_key(source, [*command, *_FLAGS])}{_SUFFIX}"
        if not path.exists():
            _compile(source, command, path)
        return ctypes.CDLL(str(path))
    except (BuildError, OSError) as error:
        _log.info("nothing is compiled, NumPy does the same more slowly: %s", error)
        return None


def cache_folder() -> Path:
    """Where libraries are kept; it may be deleted at any time."""
    return user_cache_path("flexident", appauthor=False)


def _compile(source: str, command: list[str], path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    with tempfile.TemporaryDirectory() as folder, replacing(path) as binary:
        file, compiled = (str(Path(folder) / name) for name in ("source.c", "source.o"))
        Path(file).write_text(source, encoding="utf-8")
        for step in ([*_FLAGS, "-c", file, "-o", compiled], ["-shared", compiled, "-o", str(binary), "-lm"]):
            done = subprocess.run([*command, *step], capture_output=True, text=True)
            if done.returncode:
                raise BuildError(f"the C compiler failed ({command[0]} ...):\n{done.stderr.strip()}")


def _key(source: str, command: list[str]) -> str:
    """Of what the binary depends on: the source, the compiler and, with -march=native, the processor."""
    return hashlib.sha256("\n".join([source, *command, _processor()]).encode()).hexdigest()


@cache
def _processor() -> str:
    described = Path("/proc/cpuinfo")
    if described.exists():
        lines = described.read_text(encoding="utf-8", errors="replace").splitlines()
        return "\n".join(sorted({x for x in lines if x.startswith(("model name", "flags", "Features"))}))
    return f"{platform.machine()} {platform.processor()} {platform.node()}"
