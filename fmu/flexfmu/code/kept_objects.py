"""Object files of C that this compiler has compiled before: most of the time of an export."""

import re
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from flexmodels.compiling.kept import Kept, cache_folder, key_of

_INCLUDE = re.compile(rb'^#include "([^"]+)"', re.MULTILINE)


class KeptObjects:
    """Those of one compiler; without a cache that can be read and written there are none.

    command    as it is called; zig keeps its objects itself
    """

    def __init__(self, command: list[str]):
        self._kept = Kept(".o", cache_folder() / "objects")
        self._compiler = None if "ziglang" in command else _described(command)

    def place(self, words: list[str], source: Path, path: Path, compiled: Callable[[], None]) -> None:
        """Puts the object of this call and this C at `path`: a kept one, else what `compiled` puts there."""
        if self._compiler is None:
            compiled()
            return
        # of the call, the compiler's own file, the C file and the headers beside it that it includes
        key = key_of(*words, self._compiler, *_with_headers(source))
        with suppress(OSError):
            kept = self._kept.find(key)
            if kept:
                shutil.copyfile(kept, path)
                return
        compiled()
        with suppress(OSError):
            self._kept.keep(key, path.read_bytes())


def _described(command: list[str]) -> str:
    """The compiler's own file, and that of a program that calls it."""
    files = [Path(found).resolve() for word in command if (found := shutil.which(word))]
    return "\n".join(f"{file} {file.stat().st_size} {file.stat().st_mtime_ns}" for file in files)


def _with_headers(source: Path) -> list[bytes]:
    """Content of the file and of every header of its folder that it needs, directly or through others."""
    contents, waiting = {}, [source]
    while waiting:
        file = waiting.pop()
        if file in contents or not file.is_file():
            continue
        contents[file] = file.read_bytes()
        waiting += [file.parent / name.decode() for name in _INCLUDE.findall(contents[file])]
    return [part for file in sorted(contents) for part in (file.name.encode(), contents[file])]
