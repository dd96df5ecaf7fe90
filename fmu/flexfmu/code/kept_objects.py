"""Object files of C that this compiler has compiled before: most of the time of an export."""

import re
import shutil
from contextlib import suppress
from pathlib import Path

from flexmodels.kept import Kept, cache_folder, key_of

_INCLUDE = re.compile(rb'^#include "([^"]+)"', re.MULTILINE)


class KeptObjects:
    """Those of one compiler; without a cache that can be read and written there are none.

    command    as it is called; zig keeps its objects itself
    """

    def __init__(self, command: list[str]):
        self._kept = Kept(".o", cache_folder() / "objects")
        self._compiler = None if "ziglang" in command else _described(command)

    def copy(self, words: list[str], source: Path, path: str) -> bool:
        """Puts the object of the same call and the same C at `path`; False if there is none."""
        if self._compiler is None:
            return False
        with suppress(OSError):
            kept = self._kept.find(self._key(words, source))
            if kept:
                shutil.copyfile(kept, path)
                return True
        return False

    def keep(self, words: list[str], source: Path, path: str) -> None:
        if self._compiler is not None:
            with suppress(OSError):
                self._kept.keep(self._key(words, source), Path(path).read_bytes())

    def _key(self, words: list[str], source: Path) -> str:
        """Of the call, the compiler's own file, the C file and the headers beside it that it includes."""
        return key_of(*words, self._compiler or "", *_with_headers(source))


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
