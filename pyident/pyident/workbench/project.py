"""A folder as a project: models, logs, which logs are held out, versions of the model, what was done.

All of it are files: robot files, logs and results as the command line writes them, and one small file,
`workbench.json`, with the choices that no other file holds.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from flexmodels.atomic import replacing

STATE = "workbench.json"
LOGS = (".csv", ".parquet", ".mat")
MODELS = (".toml", ".urdf", ".xml")
_FIRST = ("robot.toml", "model.toml", "identified.toml")  # the model that a fresh project starts from
LARGEST_UPLOAD = 2_000_000_000  # bytes: an hour of a six-axis arm at 1 kHz, twice over
Role = Literal["fit", "hold out", "leave out"]


class ProjectError(ValueError):
    """A folder or file that cannot be used; the message says what and how to mend it."""


@dataclass(frozen=True)
class Version:
    """One model of the strip.

    model     its file's name;  parent: that of the model it came from, empty for the first
    what      what was done, in words;  command: the command line that does the same
    fall      relative fall of the mean square error on held-out data: equations, simulation
    """

    model: str
    parent: str = ""
    what: str = "start"
    command: str = ""
    fall: tuple[float, float] | None = None


@dataclass(frozen=True)
class Project:
    """What a folder holds and what was chosen of it.

    mapping   file with the names and units of the logs' columns, empty for none
    roles     log -> what it is for; a log that is not listed is fitted
    versions  of the model, oldest first;  current: the number of the one in use
    commands  every step that was taken, as commands
    """

    folder: Path
    mapping: str = ""
    roles: dict[str, Role] = field(default_factory=dict)
    versions: tuple[Version, ...] = ()
    current: int = 0
    commands: tuple[str, ...] = ()

    @property
    def logs(self) -> list[str]:
        """Names of the files that can be logs."""
        return sorted(f.name for f in self._files() if f.suffix in LOGS)

    @property
    def models(self) -> list[str]:
        """Names of the files that can be robots."""
        return sorted(f.name for f in self._files() if f.suffix in MODELS and f.name != self.mapping)

    @property
    def model(self) -> str:
        """The model in use: a file of the folder or a shipped robot; empty before one is chosen."""
        return self.versions[self.current].model if self.versions else ""

    @property
    def strangers(self) -> list[str]:
        """Names of links to files elsewhere, which are not read."""
        own = {f.name for f in self._files()}
        return sorted(f.name for f in self._visible() if f.name not in own)

    def with_role(self, role: Role) -> list[str]:
        """The logs that serve for something."""
        return [log for log in self.logs if self.roles.get(log, "fit") == role]

    def path(self, name: str) -> Path:
        """A file of this folder. Raises ProjectError for a name that leads out of it."""
        path = (self.folder / name).resolve()
        if path.parent != self.folder.resolve() or name.startswith("."):
            raise ProjectError(f"{name!r} is not a file of this project; use a plain file name")
        return path

    def model_path(self) -> str:
        """The model in use as the front door takes it: a shipped robot's name or a path."""
        own = self.path(self.model) if self.model else Path()
        return str(own) if own.is_file() else self.model

    def _files(self) -> list[Path]:
        return [f for f in self._visible() if f.resolve().parent == self.folder.resolve()]

    def _visible(self) -> list[Path]:
        return [f for f in self.folder.iterdir() if f.is_file() and not f.name.startswith(".")]

    # Every change is a new project; `save` writes it.

    def having_role(self, log: str, role: Role) -> "Project":
        """With a log for another purpose."""
        return replace(self, roles={**self.roles, log: role})

    def starting_from(self, model: str) -> "Project":
        """With a model as the first of a new strip."""
        return replace(self, versions=(Version(model),), current=0)

    def extended(self, version: Version) -> "Project":
        """With one more version, behind the one in use; later ones are dropped."""
        kept = self.versions[: self.current + 1]
        return replace(self, versions=(*kept, version), current=len(kept))

    def at_version(self, number: int) -> "Project":
        """With another version in use. Raises ProjectError."""
        if not 0 <= number < len(self.versions):
            raise ProjectError(f"there is no version {number}; there are {len(self.versions)}")
        return replace(self, current=number)

    def after(self, command: str) -> "Project":
        """With one more step in the record."""
        return replace(self, commands=(*self.commands, command))

    def save(self) -> None:
        """Write the choices beside the files, all or nothing."""
        content = asdict(self)
        del content["folder"]
        with replacing(self.folder / STATE) as file:
            file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")

    def script(self) -> str:
        """A shell script of everything that was done."""
        return "\n".join(["#!/bin/sh", "set -e", *self.commands, ""])

    def free_name(self, stem: str, suffix: str) -> str:
        """A file name that is not taken yet."""
        names = [f"{stem}{suffix}", *(f"{stem}_{i}{suffix}" for i in range(2, 1000))]
        return next(name for name in names if not (self.folder / name).exists())


def open_project(folder: str | Path) -> Project:
    """The project in a folder. Raises ProjectError."""
    folder = Path(folder).resolve()
    if not folder.is_dir():
        raise ProjectError(f"there is no folder {folder}; make it, or check the path")
    state = folder / STATE
    if not state.is_file():
        return _fresh(folder)
    try:
        return _read(folder, json.loads(state.read_text(encoding="utf-8")))
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise ProjectError(f"{state} cannot be read ({error}); delete it to start afresh") from None


def is_worth_opening(folder: str | Path) -> bool:
    """Whether a folder holds a log and a model that a fresh project starts from."""
    project = Project(Path(folder))
    return bool(project.logs) and any(name in project.models for name in _FIRST)


def _fresh(folder: Path) -> Project:
    project = Project(folder)
    robots = [name for name in _FIRST if name in project.models]
    return project.starting_from(robots[0]) if robots else project


def _read(folder: Path, content: dict[str, Any]) -> Project:
    versions = tuple(
        Version(**{**v, "fall": None if v["fall"] is None else tuple(v["fall"])}) for v in content["versions"]
    )
    current = int(content["current"])
    if versions and not 0 <= current < len(versions):
        raise ValueError(f"no version {current}")
    return Project(
        folder,
        str(content["mapping"]),
        dict(content["roles"]),
        versions,
        current,
        tuple(map(str, content["commands"])),
    )


def command(*words: str | Path | Sequence[str]) -> str:
    """A command of this project as a shell line; files by their names, for it runs in the folder."""
    import shlex

    plain: list[str] = []
    for word in words:
        plain += [word] if isinstance(word, str) else [word.name] if isinstance(word, Path) else list(word)
    return shlex.join(["pyident", *plain])
