"""Files that a command writes: their endings, and that they destroy nothing."""

import json
import os
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

_START = 4096  # bytes of a file that tell its kind
_RECORDING = ("meta/info.json", "metadata.yaml")  # by which LeRobot's and ROS's folders are known


class OutputError(ValueError):
    """A file or folder that must not be written; the message says why."""


@dataclass(frozen=True)
class Kind:
    """What an output is called, the endings it may have, and whether an existing file (path) is one."""

    what: str
    endings: tuple[str, ...]
    holds: Callable[[Path], bool]
    article: str = "a"


class Output(click.ParamType):
    """A file to write, of one kind."""

    name = "file"

    def __init__(self, kind: Kind):
        self.kind = kind

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        return "FILE"


class OutputFolder(click.ParamType):
    """A folder to write into."""

    name = "folder"

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        return "FOLDER"


def check_outputs(context: click.Context) -> None:
    """Raises OutputError before anything is read if what the command is to write would destroy something."""
    listed = [(p, context.params.get(p.name or "")) for p in context.command.params]
    outputs = [
        (p, value) for p, value in listed if isinstance(p.type, Output | OutputFolder) and value is not None
    ]
    inputs = [path for p, value in listed if (p, value) not in outputs for path in _existing(value)]
    overwrite = bool(context.meta.get(OVERWRITE))
    for option, value in outputs:
        if isinstance(option.type, Output):
            check_output(value, option.type.kind, inputs, overwrite)
        else:
            _check_folder(value)
    names = [os.path.realpath(value) for _, value in outputs]
    for name in names:
        if names.count(name) > 1:
            raise OutputError(f"{name} would be written twice; give each output a name of its own")


def check_output(name: str, kind: Kind, inputs: list[Path], overwrite: bool) -> None:
    """Raises OutputError unless a file of this kind may be written under this name."""
    path = Path(name)
    if not name.strip() or not path.name:
        raise OutputError(f"an output has an empty name; call it, say, out{kind.endings[0]}")
    if path.is_dir():
        raise OutputError(
            f"{path} is a folder; name a file in it, such as {path / ('out' + kind.endings[0])}"
        )
    if path.exists() and not path.is_file():
        raise OutputError(f"{path} is a device or a pipe, not a file; write to a file")
    if not path.parent.is_dir():
        raise OutputError(f"{path.parent}: there is no such folder; make it first")
    if path.suffix not in kind.endings:
        raise OutputError(f"{path}: {kind.article} {kind.what} must end in {', '.join(kind.endings)}")
    for other in inputs:
        if path.exists() and (path.samefile(other) or path.resolve().is_relative_to(other.resolve())):
            raise OutputError(f"{path} is an input ({other}), which would be lost; write to another file")
    if not overwrite and path.exists() and path.stat().st_size and not _is(path, kind):
        raise OutputError(
            f"{path} exists and is no {kind.what} of ours; name another file or pass --overwrite"
        )


OVERWRITE = "flexident.overwrite"  # under which a context remembers the option


def _existing(value: Any) -> Iterator[Path]:
    """Files that an argument names, shipped robots included, and folders that hold a recording."""
    from flexmodels.files.robot_file import shipped

    for word in value if isinstance(value, tuple | list) else (value,):
        if isinstance(word, str) and word:
            path = shipped().get(word, Path(word))
            try:
                if path.is_file() or any((path / sign).is_file() for sign in _RECORDING):
                    yield path
            except OSError:
                continue


def _check_folder(name: str) -> None:
    path = Path(name)
    if not name.strip():
        raise OutputError("the output folder has an empty name; call it, say, out")
    if path.exists() and not path.is_dir():
        raise OutputError(f"{path} is a file; name a folder")


def _is(path: Path, kind: Kind) -> bool:
    try:
        return kind.holds(path)
    except (OSError, ValueError, RecursionError):
        return False


def _starts(*beginnings: bytes) -> Callable[[Path], bool]:
    return lambda path: _head(path).startswith(beginnings)


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(_START)


def _is_log(path: Path) -> bool:
    if path.suffix == ".csv":
        return b"time" in _head(path).split(b"\n")[0].replace(b'"', b"").strip().split(b",")
    return _head(path).startswith(b"PAR1" if path.suffix == ".parquet" else (b"MATLAB 5.0", b"MATLAB 7"))


def _is_mapping(path: Path) -> bool:
    try:
        return "signals" in tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError):
        return False


def _is_robot(path: Path) -> bool:
    return "joint" in tomllib.loads(path.read_text(encoding="utf-8"))


def _is_model(path: Path) -> bool:
    if path.suffix == ".json":
        return _is_json(path)
    return (b"<robot" if path.suffix == ".urdf" else b"<mujoco") in _head(path)


def _is_json(path: Path) -> bool:
    return isinstance(json.loads(path.read_text(encoding="utf-8")), dict | list)


def _is_trajectory(path: Path) -> bool:
    if path.suffix == ".csv":
        return _is_log(path)
    return b"joint_names" in _head(path)


ROBOT = Kind("robot file", (".toml",), _is_robot)
MAPPING = Kind("mapping", (".toml",), _is_mapping)
LOG = Kind("log", (".csv", ".parquet", ".mat"), _is_log)
FMU = Kind("FMU, SSP or Modelica package", (".fmu", ".ssp", ".mo"), _starts(b"PK", b"package "), "an")
MODEL = Kind("model for other simulators", (".urdf", ".xml", ".json"), _is_model)
PAGE = Kind("page", (".html",), lambda path: b'content="flexident"' in _head(path))
DRAFT = Kind("file of effects", (".py",), lambda path: False)
JSON = Kind("JSON file", (".json",), _is_json)
TRAJECTORY = Kind("trajectory", (".csv", ".json", ".yaml"), _is_trajectory)
