"""The process in which a foreign FMU runs: `python -m flexfmu.foreign.child FOLDER`, asked by `parent`.

The request comes in one line; answers are lines of JSON: {"progress": share}, then {"columns": names} beside
the result file or {"error": sentence}. Whatever the FMU prints goes nowhere.
"""

import json
import os
import shutil
import sys
import threading
from pathlib import Path
from typing import Any, BinaryIO

_STEP = 0.01  # of progress between two lines


def main(folder: Path) -> None:
    """Run the FMU that is asked for."""
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    request = json.loads(sys.stdin.buffer.readline())
    threading.Thread(target=_end_with_parent, args=(folder,), daemon=True).start()
    try:
        _say(answers, {"columns": _run(folder, request, answers)})
    except Exception as error:
        _say(answers, {"error": " ".join(str(error).split())})
    os._exit(0)  # without the FMU's own exit handlers


def _run(folder: Path, request: dict[str, Any], answers: BinaryIO) -> list[str]:
    import numpy as np

    from flexfmu.foreign.parent import REQUEST, RESULT
    from flexfmu.simulate import LoadedFmu
    from flexmodels.inputs import Experiment

    with np.load(folder / REQUEST) as arrays:
        experiment = Experiment(**{name: arrays[name][()] for name in arrays})
    told = [0.0]

    def progress(share: float) -> None:
        if share >= told[0] + _STEP:
            told[0] = share
            _say(answers, {"progress": share})

    with LoadedFmu(request["fmu"]) as fmu:
        frame = fmu.simulate(experiment, request["parameters"], tuple(request["outputs"]), progress)
    np.save(folder / RESULT, frame.to_numpy(dtype=float))
    return list(frame)


def _say(answers: BinaryIO, content: dict[str, Any]) -> None:
    answers.write(json.dumps(content).encode() + b"\n")


def _end_with_parent(folder: Path) -> None:
    """The parent keeps our standard input open as long as it lives."""
    sys.stdin.buffer.read()
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
