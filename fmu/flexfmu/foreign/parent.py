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
        progress: Callable[[float], None] | None = None,
    ) -> pd.DataFrame:
        """As `LoadedFmu.simulate`. Raises SimulationError."""
        with scratch_folder() as folder:
            parts = {f.name: getattr(experiment, f.name) for f in fields(experiment)}
            np.savez(folder / REQUEST, **{name: part for name, part in parts.items() if part is not None})
            words = {
                "fmu": str(self._path.resolve()),
                "parameters": dict(parameters or {}),
                "outputs": outputs,
            }
            answer = self._answer(folder, json.dumps(words), progress)
            rows = np.load(folder / RESULT, allow_pickle=False)
        return pd.DataFrame(rows, columns=answer["columns"])

    def _answer(self, folder: Path, request: str, progress: Callable[[float], None] | None) -> dict[str, Any]:
        command = [sys.executable, "-m", "flexfmu.foreign.child", str(folder)]
        environment = os.environ | {
            "TMPDIR": str(folder),
            "TEMP": str(folder),
            "PYTHONPATH": os.pathsep.join(sys.path),
        }
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment
        ) as child:
            try:
                return self._follow(child, request, progress)
            finally:
                child.kill()

    def _follow(
        self, child: "subprocess.Popen[bytes]", request: str, progress: Callable[[float], None] | None
    ) -> dict[str, Any]:
        """Send the request, pass progress on and return the last line. Raises SimulationError."""
        lines: list[dict[str, Any]] = []
        reader = threading.Thread(target=_collect, args=(child, lines), daemon=True)
        reader.start()
        assert child.stdin is not None
        try:
            child.stdin.write(request.encode() + b"\n")  # kept open: its end tells the child to end too
            child.stdin.flush()
        except BrokenPipeError:
            pass  # its end is explained below
        seen, heard = 0, time.monotonic()
        while reader.is_alive():
            reader.join(_POLL)
            if len(lines) > seen:
                seen, heard = len(lines), time.monotonic()
                if progress and "progress" in lines[-1]:
                    progress(lines[-1]["progress"])
            if time.monotonic() - heard > self._silence:
                raise SimulationError(
                    f"{self._path}: the FMU gave no sign for {self._silence:g} s and was stopped"
                )
        last = lines[-1] if lines else {}
        if "error" in last:
            raise SimulationError(f"{self._path}: {last['error']}")
        if "columns" not in last:
            raise SimulationError(f"{self._path}: the FMU {_ending(child.wait())}")
        return last


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
