"""Which version of the code made a result: long studies mix no results of two."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

import flexfmu
import flexmodels
import pyident

_KINDS = ("py", "c", "h", "toml")


def code_version(setting: str = "", own: Iterable[Path] = ()) -> str:
    """A digest of the packages' files, of a study's own and of a setting."""
    digest, files = hashlib.sha256(setting.encode()), set(own)
    for package in (flexmodels, flexfmu, pyident):
        root = Path(str(package.__file__)).parent
        files.update(f for kind in _KINDS for f in root.rglob(f"*.{kind}"))
    for file in sorted(files):
        digest.update(file.read_bytes())
    return digest.hexdigest()
