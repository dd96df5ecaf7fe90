"""Temporary folders that are gone when their process is, however it ends.

All of a process lie in one folder. A janitor, a shell that waits for the end of a pipe, removes it when the
process was killed and could not do so itself.
"""

import atexit
import os
import shutil
import subprocess
import tempfile
import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_JANITOR = 'while read -r line; do :; done; rm -rf -- "$1"'
_roots: dict[int, Path] = {}  # by process, for those that fork
_one_at_a_time = threading.Lock()  # of its threads
_janitors: dict[int, subprocess.Popen[bytes]] = {}


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """An empty folder, removed with all it holds when the block ends or the process dies."""
    folder = _root() / uuid.uuid4().hex
    try:
        folder.mkdir(mode=0o700)
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _root() -> Path:
    process = os.getpid()
    with _one_at_a_time:
        if process not in _roots or not _roots[process].is_dir():
            _roots[process] = Path(tempfile.gettempdir()) / f"flexident-{uuid.uuid4().hex}"
            atexit.register(_clean, process)  # known before it is there: Ctrl-C may come at any time
            _watch(process)
            _roots[process].mkdir(mode=0o700)
    return _roots[process]


def _watch(process: int) -> None:
    shell = shutil.which("sh")
    if shell is None:  # Windows
        return
    with suppress(OSError):
        _janitors[process] = subprocess.Popen(
            [shell, "-c", _JANITOR, "sh", str(_roots[process])],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd="/",
            start_new_session=True,
        )


def _clean(process: int) -> None:
    if process != os.getpid():
        return
    shutil.rmtree(_roots[process], ignore_errors=True)
    janitor = _janitors.pop(process, None)
    if janitor is not None and janitor.stdin is not None:
        janitor.stdin.close()
        janitor.wait()
