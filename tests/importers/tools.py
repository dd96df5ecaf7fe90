"""The tools, and how one is asked to run an FMU."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from importers.environment import fmilibrary, fmusim, scripts_of
from importers.request import CPU_SECONDS

HERE = Path(__file__).parent
EXACT = 1e-12  # [m] the same arithmetic, called by somebody else
ROUNDED = 1e-11  # [m] inputs set, not extrapolated: their last bit moves a located event by a rounding
SOLVED = 1e-6  # [m] another solver and another event location; the project's accuracy of the tip
ALARMS = ("warn", "error", "critical", "fatal", "not implemented")


@dataclass(frozen=True)
class Tool:
    """An importer.

    title          what it is called, with its version
    script         runs it
    requirements   of pip, in an environment of its own; None: the project's environment
    tolerance      how far its tip may be from ours [m or rad]
    versions       of FMI that it runs without a fault of its own (see docs/importers.md)
    native         makes the tool where it is no Python package
    expected       lines that it is known to complain with, as a pattern
    """

    title: str
    script: str
    interface: str
    tolerance: float
    requirements: str | None = None
    versions: tuple[int, ...] = (2, 3)
    event_mode: bool = False
    native: Callable[[], Path] | None = None
    expected: str | None = None


@dataclass(frozen=True)
class Answer:
    """Variable -> its values after each step; CPU seconds of loading and running; complaints."""

    rows: Mapping[str, np.ndarray]
    seconds: float
    complaints: tuple[str, ...]


_CS, _ME = "CoSimulation", "ModelExchange"
_FMULOADER, _PATHSIM = "fmuloader==0.1.2rc0", "pathsim-fmi==0.1.1"
FMPY = Tool("FMPy 0.3.32", "run_fmpy.py", _CS, EXACT)
_FMUSIM = Tool("fmusim (Reference-FMUs c8d4e6d9)", "run_fmusim.py", _CS, EXACT, native=fmusim)
_FMIL = Tool(
    "FMILibrary 3 (1599ab1e)",
    "run_fmilibrary.py",
    _CS,
    EXACT,
    native=fmilibrary,
    expected=r"Unknown attribute '(matchingRule|memberName|variable\w+)=|element 'Terminal'",
)
_LOADER = Tool("fmuloader 0.1.2rc0", "run_fmuloader.py", _CS, EXACT, _FMULOADER)
_PATH = Tool("PathSim + pathsim-fmi 0.1.1", "run_pathsim.py", _CS, EXACT, _PATHSIM)
TOOLS = {
    "fmpy-cs": FMPY,
    "fmpy-cs-event-mode": replace(FMPY, versions=(3,), event_mode=True, tolerance=ROUNDED),
    "fmpy-cvode": replace(FMPY, interface=_ME, tolerance=SOLVED),
    "fmusim-cs": _FMUSIM,
    "fmusim-cvode": replace(_FMUSIM, interface=_ME, tolerance=SOLVED),
    "fmilibrary-cs": _FMIL,
    "fmilibrary-me": replace(_FMIL, interface=_ME, tolerance=SOLVED),
    "fmuloader-cs": _LOADER,
    "fmuloader-me": replace(_LOADER, interface=_ME, tolerance=SOLVED),
    "pathsim-cs": _PATH,
    "pathsim-me": replace(_PATH, interface=_ME, tolerance=SOLVED),
    "cofmupy-cs": Tool("CoFMUPy 1.0.0", "run_cofmupy.py", _CS, EXACT, "cofmupy==1.0.0"),
    "ecos-cs": Tool("ecos (ecospy 0.7.2)", "run_ecos.py", _CS, EXACT, "ecospy==0.7.2 tbb", versions=(2,)),
    "libcosim-cs": Tool(
        "libcosim (libcosimpy 0.0.6)", "run_libcosim.py", _CS, EXACT, "libcosimpy==0.0.6", versions=(2,)
    ),
}


def ask(tool: Tool, folder: Path, request: Mapping[str, object]) -> Answer:
    """The answer of a tool's script to a request (importers/request.py, without the tool's own part).

    Raises CannotInstall; AssertionError with what the tool said where it fails.
    """
    python = scripts_of(tool.requirements) / "python" if tool.requirements else sys.executable
    own = {"interface": tool.interface, "event_mode": tool.event_mode}
    own["tool"] = str(tool.native()) if tool.native else ""
    (folder / "request.json").write_text(json.dumps({**own, **request}))
    said = say([python, HERE / tool.script, folder / "request.json", folder / "answer.json"])
    answer = {name: np.array(v) for name, v in json.loads((folder / "answer.json").read_text()).items()}
    seconds = float(answer.pop(CPU_SECONDS)[0])
    lines = [line.strip() for line in said.splitlines()]
    alarms = [line for line in lines if any(word in line.lower() for word in ALARMS)]
    return Answer(answer, seconds, tuple(alarms))


def say(command: list) -> str:
    """What a command prints; it must succeed. Tools of the project's environment are on its path."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    env = os.environ | {"PATH": path}
    done = subprocess.run(command, capture_output=True, text=True, timeout=180, env=env)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said[-2000:]
    return said
