"""C source -> a library of this machine, compiled once and kept in the user's cache."""

import ctypes
import hashlib
import logging
import platform
import subprocess
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

from platformdirs import user_cache_path

from flexmodels.atomic import replacing
from flexmodels.compiler import BuildError, compiler
from flexmodels.scratch import scratch_folder

# -ffast-math for sines of several samples at once; never given to the linker, where it changes the process.
_FLAGS = ["-std=c11", "-O3", "-march=native", "-ffast-math"]
_FLAGS += [] if sys.platform == "win32" else ["-fPIC"]
_SUFFIX = ".dll" if sys.platform == "win32" else ".so"
_log = logging.getLogger(__name__)


def library(source: str) -> ctypes.CDLL | None:
    """The compiled source; None where it cannot be compiled or loaded, with a note to the log."""
    try:
        command = compiler()
        key = _key(source, [*command, *_FLAGS])
        path = _kept(key) or _compile(source, command, key)
        return ctypes.CDLL(str(path))
    except (BuildError, OSError) as error:
        _log.info("nothing is compiled, NumPy does the same more slowly: %s", error)
        return None


def cache_folder() -> Path:
    """Where libraries are kept; it may be deleted at any time."""
    return user_cache_path("flexident", appauthor=False)


def _kept(key: str) -> Path | None:
    """The library of this key whose content is what its name says; damaged ones are removed."""
    for path in cache_folder().glob(f"{key}-*{_SUFFIX}"):
        if path.stem.endswith(_digest(path.read_bytes())):
            return path
        with suppress(OSError):
            path.unlink()
    return None


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _compile(source: str, command: list[str], key: str) -> Path:
    """Into the cache, under a name with the content's checksum: whole, or not there at all."""
    cache_folder().mkdir(parents=True, exist_ok=True, mode=0o700)
    with scratch_folder() as folder:
        file, compiled, binary = (str(folder / name) for name in ("source.c", "source.o", "library"))
        Path(file).write_text(source, encoding="utf-8")
        for step in ([*_FLAGS, "-c", file, "-o", compiled], ["-shared", compiled, "-o", binary, "-lm"]):
            done = subprocess.run([*command, *step], capture_output=True, text=True)
            if done.returncode:
                raise BuildError(f"the C compiler failed ({command[0]} ...):\n{done.stderr.strip()}")
        content = Path(binary).read_bytes()
        path = cache_folder() / f"{key}-{_digest(content)}{_SUFFIX}"
        with replacing(path) as temporary:
            temporary.write_bytes(content)
    return path


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
