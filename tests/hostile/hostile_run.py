"""Runs the command on hostile input, and sees what it changed around it."""

import hashlib
import os
import tempfile
from pathlib import Path

from click.testing import CliRunner, Result
from hypothesis import HealthCheck, Phase, settings

from flexmodels import scratch
from pyident.cli.main import main

GOOD_CODES = (0, 1, 2)
FULL = "HOSTILE_EXAMPLES" in os.environ
MANY = settings(
    max_examples=int(os.environ.get("HOSTILE_EXAMPLES", "25")),
    deadline=None,
    derandomize=not FULL,
    database=None,
    suppress_health_check=list(HealthCheck),  # pyright: ignore[reportArgumentType]
    phases=(Phase.explicit, Phase.generate),
)


def run(*words: object) -> Result:
    """The command in this process; a fault of ours has the exit code 70."""
    return CliRunner().invoke(main, [str(word) for word in words])


def fault(done: Result) -> str | None:
    """Why the ending of a command is none that a user should see; None: it is fine."""
    leaked = done.exception is not None and not isinstance(done.exception, SystemExit)
    if leaked or done.exit_code not in GOOD_CODES or "Traceback" in done.output:
        return f"exit code {done.exit_code}: {done.output[-800:]} {done.exception!r}"
    if done.exit_code == 2 and "Usage:" not in done.output and not done.output.strip():
        return "a silent end with exit code 2"
    return None


class Surroundings:
    """What a command must leave as it is: the files of a folder, the temporary folder, child processes."""

    def __init__(self, folder: Path):
        self._folder, self._before = folder, self._seen(folder)

    def changes(self, new: tuple[str, ...] = ()) -> list[str]:
        """What is new, gone or changed, but for files that are expected (`new`)."""
        after = self._seen(self._folder)
        keys = {key for key in after.keys() | self._before.keys() if after.get(key) != self._before.get(key)}
        return sorted(key for key in keys if Path(key).name not in new)

    @staticmethod
    def _seen(folder: Path) -> dict[str, str]:
        files = {str(p): _digest(p) for p in folder.rglob("*") if not p.is_dir()}
        temporary = Path(tempfile.gettempdir())
        left = {str(p): "" for p in (*temporary.glob("*"), *temporary.glob("flexident-*/*"))}
        kept = {str(root) for root in scratch._roots.values()}  # while this process lives
        seen = {name: digest for name, digest in (files | left).items() if name not in kept}
        return seen | {f"process {name}": "" for name in children()}


def children() -> set[str]:
    """Child processes of this one, but for the janitor of its temporary folder."""
    found = set()
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, rest = status.read_text().rsplit(")", 1)
            command = (status.parent / "cmdline").read_bytes()
        except OSError:
            continue
        if int(rest.split()[1]) == os.getpid() and b"read -r line" not in command:
            found.add(name.replace("(", ""))
    return found


def _digest(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return "unreadable"


TRIED: dict[str, int] = {}


def counted(family: str, number: int = 1) -> None:
    """One more hostile input of a family was tried; the sums stand at the end of the run."""
    TRIED[family] = TRIED.get(family, 0) + number


def tried(family: str, folder: Path, files: dict[str, bytes], *words: str) -> Result:
    """Run a command on these files. It must end well; only its outputs out.* are new, where it ran."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    before = Surroundings(folder)
    done = run(*words)
    counted(family)
    assert fault(done) is None, f"{fault(done)}\n{files}"
    new = () if done.exit_code == 2 else tuple(file.name for file in folder.glob("out.*"))
    assert before.changes(new) == [], files
    return done


def cleared(folder: Path) -> None:
    """Without its outputs."""
    for file in folder.glob("out.*"):
        file.unlink()
