"""Results in files of their own, whole or not at all, with the version of the code that made them."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexmodels.atomic import replacing

_OF = "of"


def write_json(file: Path, content: Mapping[str, Any]) -> None:
    """Its folder is made where there is none."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with replacing(file) as temporary:
        temporary.write_text(json.dumps(content, indent=2), encoding="utf-8")


def keep(file: Path, of: str, content: Mapping[str, Any]) -> None:
    """of: see `code_version`."""
    write_json(file, {_OF: of, **content})


def kept(file: Path, of: str) -> dict[str, Any] | None:
    """What this very version kept; None where there is no such file, or another version wrote it."""
    if not file.is_file():
        return None
    content = json.loads(file.read_text(encoding="utf-8"))
    return content if content.pop(_OF, None) == of else None
