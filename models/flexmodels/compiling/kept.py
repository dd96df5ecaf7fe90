"""What a compiler made, kept in the user's cache under what it was made from."""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from platformdirs import user_cache_path

from flexmodels.atomic import replacing

_LARGEST = 2**29  # bytes of a folder; what was used longest ago goes first


def cache_folder() -> Path:
    """Where it is kept; it may be deleted at any time."""
    return user_cache_path("flexident", appauthor=False)


class Kept:
    """Files of one ending in a folder of the cache: `key-checksum.ending`, whole or not there at all."""

    def __init__(self, suffix: str, folder: Path):
        self._suffix, self._folder = suffix, folder

    def find(self, key: str) -> Path | None:
        """The file of this key whose content is what its name says; damaged ones are removed."""
        for path in self._folder.glob(f"{key}-*{self._suffix}"):
            with suppress(OSError):
                if path.stem.endswith(_digest(path.read_bytes())):
                    os.utime(path)
                    return path
                path.unlink()
        return None

    def keep(self, key: str, content: bytes) -> Path:
        """Raises OSError where the cache cannot be written."""
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        path = self._folder / f"{key}-{_digest(content)}{self._suffix}"
        with replacing(path) as temporary:
            temporary.write_bytes(content)
        self._make_room()
        return path

    def _make_room(self) -> None:
        ages = []
        for path in self._folder.glob(f"*{self._suffix}"):
            with suppress(OSError):  # another process removed it
                status = path.stat()
                ages.append((status.st_mtime, status.st_size, path))
        total = sum(size for _, size, _ in ages)
        for _, size, path in sorted(ages):
            if total <= _LARGEST:
                return
            total -= size
            with suppress(OSError):
                path.unlink()


def key_of(*parts: str | bytes) -> str:
    """A key of all that a file is made from."""
    key = hashlib.sha256()
    for part in parts:
        content = part.encode() if isinstance(part, str) else part
        key.update(f"{len(content)} ".encode() + content)
    return key.hexdigest()


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
