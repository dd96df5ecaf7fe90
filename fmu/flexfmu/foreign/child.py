"""The process in which a foreign FMU runs: `python -m flexfmu.foreign.child FOLDER`, asked by `parent`.

Requests come as lines of JSON; answers are lines of JSON: {"progress": share}, then {"done": what} beside the
result file or {"error": sentence}. Whatever the FMU prints goes nowhere.
"""

import json
import os
import queue
import shutil
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

_STEP = 0.01  # of progress between two lines


def main(folder: Path) -> None:
    """Run the FMUs that are asked for, one after the other, as long as the parent lives."""
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    requests: queue.Queue[dict[str, Any]] = queue.Queue()
    threading.Thread(target=_listen, args=(folder, requests), daemon=True).start()
    while True:
        request = requests.get()
        try:
            done = _JOBS[request["job"]](folder, request, _Progress(answers))
            _say(answers, {"done": done})
        except Exception as error:
            _say(answers, {"error": " ".join(str(error).split()) or type(error).__name__})


class _Progress:
    def __init__(self, answers: BinaryIO):
        self._answers, self._told = answers, 0.0

    def __call__(self, share: float) -> None:
        if share >= self._told + _STEP:
            self._told = share
            _say(self._answers, {"progress": share})


def _log(folder: Path, request: dict[str, Any], progress: Callable[[float], None]) -> list[str]:
    """An experiment of the log contract; the result's columns."""
    import numpy as np

    from flexfmu.foreign.parent import REQUEST, RESULT
    from flexfmu.simulate import LoadedFmu
    from flexmodels.inputs import Experiment

    with np.load(folder / REQUEST) as arrays:
        experiment = Experiment(**{name: arrays[name][()] for name in arrays})
    with LoadedFmu(request["fmu"]) as fmu:
        frame = fmu.simulate(experiment, request["parameters"], tuple(request["outputs"]), progress)
    np.save(folder / RESULT, frame.to_numpy(dtype=float))
    return list(frame)


def _signals(folder: Path, request: dict[str, Any], progress: Callable[[float], None]) -> list[str]:
    """Runs of any FMU under given inputs."""
    from flexfmu.foreign.runs import run

    return run(folder, request, progress)


def _slopes(folder: Path, request: dict[str, Any], progress: Callable[[float], None]) -> list[str]:
    """Sensitivities of a run in model exchange."""
    from flexfmu.foreign.runs import slopes

    return slopes(folder, request, progress)


_JOBS = {"log": _log, "signals": _signals, "slopes": _slopes}


def _say(answers: BinaryIO, content: dict[str, Any]) -> None:
    answers.write(json.dumps(content).encode() + b"\n")


def _listen(folder: Path, requests: "queue.Queue[dict[str, Any]]") -> None:
    """The parent keeps our standard input open as long as it lives."""
    for line in sys.stdin.buffer:
        requests.put(json.loads(line))
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(0)  # without the FMU's own exit handlers


if __name__ == "__main__":
    main(Path(sys.argv[1]))
