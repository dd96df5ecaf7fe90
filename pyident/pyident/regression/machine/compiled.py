"""C source -> a library of this machine, compiled once and kept in the user's cache."""

import ctypes
import logging
import platform
import subprocess
import sys
from functools import cache
from pathlib import Path

from flexmodels.compiling.compiler import BuildError, compiler
from flexmodels.compiling.kept import Kept, cache_folder, key_of
from flexmodels.scratch import scratch_folder

# -ffast-math for sines of several samples at once; never given to the linker, where it changes the process.
_FLAGS = ["-std=c11", "-O3", "-march=native", "-ffast-math"]
_FLAGS += [] if sys.platform == "win32" else ["-fPIC"]
_SUFFIX = ".dll" if sys.platform == "win32" else ".so"
_log = logging.getLogger(__name__)


def library(source: str) -> ctypes.CDLL | None:
    """The compiled source; None where it cannot be compiled or loaded, with a note to the log."""
    try:
        command, kept = compiler(), Kept(_SUFFIX, cache_folder())
        key = key_of(source, *command, *_FLAGS, _processor())  # of -march=native
        path = kept.find(key) or kept.keep(key, _compiled(source, command))
        return ctypes.CDLL(str(path))
    except (BuildError, OSError) as error:
        _log.info("nothing is compiled, NumPy does the same more slowly: %s", error)
        return None


def _compiled(source: str, command: list[str]) -> bytes:
    with scratch_folder() as folder:
        file, compiled, binary = (str(folder / name) for name in ("source.c", "source.o", "library"))
        Path(file).write_text(source, encoding="utf-8")
        for step in ([*_FLAGS, "-c", file, "-o", compiled], ["-shared", compiled, "-o", binary, "-lm"]):
            done = subprocess.run([*command, *step], capture_output=True, text=True)
            if done.returncode:
                raise BuildError(f"the C compiler failed ({command[0]} ...):\n{done.stderr.strip()}")
        return Path(binary).read_bytes()


@cache
def _processor() -> str:
    described = Path("/proc/cpuinfo")
    if described.exists():
        lines = described.read_text(encoding="utf-8", errors="replace").splitlines()
        return "\n".join(sorted({x for x in lines if x.startswith(("model name", "flags", "Features"))}))
    return f"{platform.machine()} {platform.processor()} {platform.node()}"
