"""Virtual environments for tools that shall not, or cannot, share the project's own."""

import hashlib
import os
import subprocess
import sys
import venv
from functools import cache
from pathlib import Path


class CannotInstall(RuntimeError):
    """pip could not install a tool; the message has pip's last line."""


def cache_folder() -> Path:
    return Path(os.environ.get("FLEXIDENT_TOOL_ENVS", "~/.cache/flexident-tools")).expanduser()


@cache
def scripts_of(requirement: str) -> Path:
    """Folder of the executables of an environment that has the requirement, made at the first call."""
    key = hashlib.sha256(f"{sys.version} {requirement}".encode()).hexdigest()[:8]
    folder = cache_folder() / f"{requirement.split('=')[0]}-{key}"
    scripts = folder / ("Scripts" if sys.platform == "win32" else "bin")
    complete = folder / "complete"
    if not complete.exists():
        venv.create(folder, clear=True, with_pip=True)
        pip = [str(scripts / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        done = subprocess.run([*pip, requirement], capture_output=True, text=True)
        if done.returncode:
            reason = (done.stderr.strip() or "pip failed").splitlines()[-1]
            raise CannotInstall(f"pip cannot install {requirement}: {reason}")
        complete.write_text(requirement)
    return scripts
