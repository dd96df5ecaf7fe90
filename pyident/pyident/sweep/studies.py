"""Finds the studies: folders with a study.py, beside the packages or inside the installed wheel.

As `__path__` names their folder, studies/<name>/<file>.py is the module pyident.sweep.studies.<name>.<file>,
in the processes of a study as well.
"""

import importlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Study = Callable[..., "StudyResult"]  # of a folder and of what to call with the share that is done


@dataclass(frozen=True)
class StudyResult:
    """rows: what, value, goal and met ("yes", "no", "-") each; figures: files written; notes: sentences."""

    rows: list[dict[str, Any]]
    figures: list[Path] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def row(what: str, value: str, goal: str = "", met: bool | None = None) -> dict[str, str]:
    """One line of a study's table."""
    return {"what": what, "value": value, "goal": goal, "met": "-" if met is None else "yes" if met else "no"}


def study_names() -> list[str]:
    """What `pyident study` takes, sorted."""
    return sorted(file.parent.name for file in _folder().glob("*/study.py"))


def find_study(name: str) -> Study | None:
    """The function `run` of studies/<name>/study.py, None when there is no such study."""
    if name not in study_names():
        return None
    return importlib.import_module(f"{__name__}.{name}.study").run


def _folder() -> Path:
    installed = Path(__file__).parents[1] / "_studies"
    return installed if installed.is_dir() else Path(__file__).parents[3] / "studies"


__path__ = [str(_folder())]
