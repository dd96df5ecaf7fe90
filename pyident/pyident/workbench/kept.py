"""Results that outlive the server: files in the project, found again for exactly the inputs that they are of.

Comparisons are not among them: they hold every sample of every log and are as soon made anew.
"""

import json
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from flexmodels.atomic import replacing
from pyident.diagnosis.result import Diagnosis
from pyident.workbench.work import Fitted, Inputs, Outcome

_FOLDER = Path("results") / "kept"
_KINDS = {
    "check": TypeAdapter(dict[str, list[str]]),
    "diagnose": TypeAdapter(Diagnosis),
    "add": TypeAdapter(Outcome),
    "identify": TypeAdapter(Fitted),
}


def keep(folder: Path, what: str, inputs: Inputs, result: Any) -> None:
    """Write a result into the project's folder if it is of a kind that is kept."""
    if what not in _KINDS:
        return
    path = _file(folder, what, inputs)
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as file:
        file.write_text(json.dumps(_KINDS[what].dump_python(result)) + "\n", encoding="utf-8")


def kept(folder: Path, what: str, inputs: Inputs) -> Any:
    """The result that was kept, None where there is none of these inputs or it cannot be read."""
    if what not in _KINDS:
        return None
    try:
        found = json.loads(_file(folder, what, inputs).read_text(encoding="utf-8"))
        return _KINDS[what].validate_python(found)
    except (OSError, ValueError, ValidationError):
        return None


def _file(folder: Path, what: str, inputs: Inputs) -> Path:
    """Named by what the inputs are: where a file has changed since, or pyident has, it is not found."""
    return folder / _FOLDER / f"{what}_{sha256(_said(inputs).encode()).hexdigest()[:16]}.json"


def _said(inputs: Inputs) -> str:
    parts = [[inputs.model], inputs.logs, inputs.heldout, [inputs.mapping] if inputs.mapping else []]
    return json.dumps([version("flexident"), *([_stamp(Path(name)) for name in names] for names in parts)])


def _stamp(path: Path) -> list[str | int]:
    """Name, size and time of the last change; the name alone of a robot that ships."""
    try:
        status = path.stat()
    except OSError:
        return [path.name]
    return [path.name, status.st_size, status.st_mtime_ns]
