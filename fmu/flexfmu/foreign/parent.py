"""An FMU of unknown origin runs in a process of its own: what it does there does not harm this one.

Its binary may be missing, crash, end the process, hang or return no numbers. Each becomes a SimulationError.
"""

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from flexfmu.fmu_file import FmuDescription
from flexmodels.inputs import Experiment, SimulationError
from flexmodels.scratch import scratch_folder

SILENCE = 60.0  # [s] without progress after which an FMU counts as hanging
REQUEST, RESULT = "request.npz", "result.npy"
_POLL = 0.05  # [s]
Progress = Callable[[float], None]


class Child:
    """A process that runs one FMU as often as it is asked; use as a context manager.

    fmu       path of the FMU
    folder    where requests and results lie
    silence   seconds without progress after which it is stopped
    """

    def __init__(self, fmu: Path, folder: Path, silence: float):
        self._fmu, self._silence = fmu, silence
        environment = os.environ | {
            "TMPDIR": str(folder),
            "TEMP": str(folder),
            "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
            "PYTHONSAFEPATH": "1",  # a module that lies where the command is called is not this one's
        }
        command = [sys.executable, "-m", "flexfmu.foreign.child", str(folder)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
        )
        self._lines: list[dict[str, Any]] = []
        self._reader = threading.Thread(target=_collect, args=(self._process, self._lines), daemon=True)
        self._reader.start()

    def __enter__(self) -> "Child":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        with suppress(BrokenPipeError):
            self._process.__exit__(None, None, None)

    def ask(self, job: str, request: Mapping[str, Any], progress: Progress | None = None) -> list[str]:
        """Send a request, pass progress on and return what was done. Raises SimulationError."""
        assert self._process.stdin is not None
        seen, heard = len(self._lines), time.monotonic()
        words = {"job": job, "fmu": str(self._fmu.resolve())} | dict(request)
        with suppress(BrokenPipeError):  # its end is explained below
            self._process.stdin.write(json.dumps(words).encode() + b"\n")
            self._process.stdin.flush()
        while True:
            alive = self._reader.is_alive()
            if len(self._lines) > seen:
                seen, heard = len(self._lines), time.monotonic()
                last = self._lines[-1]
                if "error" in last:
                    raise SimulationError(f"{self._fmu}: {last['error']}")
                if "done" in last:
                    return last["done"]
                if progress and "progress" in last:
                    progress(last["progress"])
            elif not alive:
                raise SimulationError(f"{self._fmu}: the FMU {_ending(self._process.wait())}")
            if time.monotonic() - heard > self._silence:
                raise SimulationError(
                    f"{self._fmu}: the FMU did not respond for {self._silence:g} s and was stopped"
                )
            self._reader.join(_POLL if seen else _POLL / 10)


class ForeignFmu(FmuDescription):
    """An FMU that is simulated in a child process, as `LoadedFmu` does in this one.

    silence   seconds without progress after which the child is stopped
    """

    def __init__(self, path: str | Path, silence: float = SILENCE):
        super().__init__(path)
        self._path, self._silence = Path(path), silence

    def simulate(
        self,
        experiment: Experiment,
        parameters: Mapping[str, float] | None = None,
        outputs: tuple[str, ...] = (),
        progress: Progress | None = None,
    ) -> pd.DataFrame:
        """As `LoadedFmu.simulate`. Raises SimulationError."""
        with scratch_folder() as folder, Child(self._path, folder, self._silence) as child:
            parts = {f.name: getattr(experiment, f.name) for f in fields(experiment)}
            np.savez(folder / REQUEST, **{name: part for name, part in parts.items() if part is not None})
            columns = child.ask("log", {"parameters": dict(parameters or {}), "outputs": outputs}, progress)
            rows = np.load(folder / RESULT, allow_pickle=False)
        return pd.DataFrame(rows, columns=columns)


def _collect(child: "subprocess.Popen[bytes]", lines: list[dict[str, Any]]) -> None:
    assert child.stdout is not None
    for line in child.stdout:
        try:
            content = json.loads(line)
        except ValueError:
            continue
        if isinstance(content, dict):
            lines.append(content)


def _ending(code: int) -> str:
    if code < 0:
        return f"crashed (signal {-code})"
    return f"ended its process by itself (exit code {code})"
