"""Finds a C compiler: the machine's own, or the one that pip installs."""

import os
import shutil
import sys
from importlib.util import find_spec


class BuildError(RuntimeError):
    """C could not be compiled; the message says why and how to mend it."""


def compiler() -> list[str]:
    """The command of the C compiler: $CC, else cc, gcc or clang, else zig from the package ziglang."""
    if os.environ.get("CC"):
        return os.environ["CC"].split()
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    return zig()


def zig() -> list[str]:
    """The command of zig's C compiler, which compiles for every platform. Raises BuildError."""
    if find_spec("ziglang") is None:
        raise BuildError("the compiler of the package ziglang is needed: pip install 'flexident[compiler]'")
    return [sys.executable, "-m", "ziglang", "cc"]
