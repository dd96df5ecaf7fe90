"""Which Python files of effects may run: a robot file is data until its user says otherwise.

Trust is recorded by content (SHA-256) in the user's configuration, so a file that changes has to be trusted
anew.
"""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path, PurePosixPath, PureWindowsPath

from platformdirs import user_config_path

from flexmodels.atomic import replacing
from flexmodels.effects.law_names import EffectError

_allowed: ContextVar[bool] = ContextVar("allowed", default=False)
_SHOWN = 12  # digits of a SHA-256 in a sentence


@contextmanager
def code_allowed() -> Iterator[None]:
    """Within the block every Python file that a robot file or a plan names may run."""
    token = _allowed.set(True)
    try:
        yield
    finally:
        _allowed.reset(token)


def allowed_file(name: str, folder: Path, option: str, allow: bool = False) -> Path:
    """The Python file that a file in `folder` names, resolved. Raises EffectError unless it may run.

    option   what the user passes to allow it, for the message
    """
    path = _beside(name, folder)
    if not path.is_file():
        raise EffectError(f"there is no Python file {path}")
    digest = fingerprint(path)
    if allow or _allowed.get() or digest in trusted():
        return path
    raise EffectError(
        f"{path} is Python code that would be run (SHA-256 {digest[:_SHOWN]}...); read it, then pass "
        f"{option}, or trust this very file from now on: pyident trust {path.name}"
    )


def fingerprint(path: str | Path) -> str:
    """SHA-256 of a file's content."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def trust(path: str | Path) -> str:
    """Record that this content may run from now on; its SHA-256. Raises OSError."""
    digest = fingerprint(path)
    lines = {**trusted(), digest: Path(path).name}
    record = _record()
    record.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    with replacing(record) as file:
        file.write_text("".join(f"{key} {name!a}\n" for key, name in lines.items()), encoding="ascii")
    return digest


def trusted() -> dict[str, str]:
    """SHA-256 -> name of what was trusted. A line that cannot be read trusts nothing."""
    try:
        lines = _record().read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return {}
    words = (line.partition(" ") for line in lines)
    return {digest: name.strip("'\"") for digest, _, name in words if len(digest) == 64}


def _record() -> Path:
    return user_config_path("flexident", appauthor=False) / "trusted_code.txt"


def _beside(name: str, folder: Path) -> Path:
    """A path below the folder; absolute ones, `..` and links that lead out of it are refused."""
    forms = (PurePosixPath(name), PureWindowsPath(name))
    outside = any(p.is_absolute() or p.drive or p.root or ".." in p.parts for p in forms)
    if not name or "\0" in name or outside:
        raise EffectError(f"{name!r} must be a file beside this one, with neither `..` nor an absolute path")
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise EffectError(f"{name!r} is a link that leads elsewhere; put the file itself beside this one")
    return path
