"""Files are written whole or not at all."""

import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from errno import ENOENT
from pathlib import Path


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary file beside `path` (same ending) that takes its place when the block ends well.

    Raises FileNotFoundError.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(ENOENT, "there is no such folder; make it first", str(path.parent))
    temporary = path.with_name(f".{path.stem[:100]}.{os.getpid()}.{uuid.uuid4().hex[:8]}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
