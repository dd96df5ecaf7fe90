"""A parameter study as a TOML file: model, experiment, design and ranges of the parameters.

model = "four_link"             # a robot, or an FMU (its experiment and ranges are then absolute)
experiment = "line"
design = "morris"               # grid, latin_hypercube, sobol, morris, sobol_indices
runs = 200                      # grid: none, the values decide
metrics = ["tip_error", "my_metrics.py:overshoot"]
[parameters]
"joint*.k[*]" = 0.25            # own value plus and minus 25 %
"joint1.coulomb" = [20.0, 40.0] # from, to; grid: every value
"""

import fnmatch
import importlib.util
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import pandas as pd

from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot
from flexmodels.files.toml_table import Table, number
from flexmodels.robot import Robot, RobotError
from pyident.simulation.fmu_runs import fmu_joints
from pyident.simulation.references import ExperimentError, load_experiment, read_experiment
from pyident.sweep.metrics import METRICS, Metric
from pyident.sweep.sampling import Ranges, grid, latin_hypercube, sobol
from pyident.sweep.sensitivity import Method, morris_design, sobol_indices_design
from pyident.sweep.store import StudyError

_RUNS = 200
_SAMPLED: dict[str, Callable[[Ranges, int, int], pd.DataFrame]] = {
    "latin_hypercube": latin_hypercube,
    "sobol": sobol,
    "morris": morris_design,
    "sobol_indices": sobol_indices_design,
}


@dataclass(frozen=True)
class StudyPlan:
    """What to run.

    model     a robot, or the path of an FMU
    ranges    lowest and highest value of every parameter that varies
    design    a row per run
    method    of the sensitivities that the design allows, if any
    """

    model: Robot | Path
    experiment: Experiment
    ranges: Ranges
    design: pd.DataFrame
    method: Method | None
    metrics: Mapping[str, Metric]


def load_study_plan(
    path: str | Path, parameters: Mapping[str, float] | None = None, allow_effects: bool = False
) -> StudyPlan:
    """Read a plan; files that it names are beside it. Raises StudyError, RobotError, ExperimentError.

    parameters      values that replace the robot's own, before the plan's shares are taken of them
    allow_effects   run the Python files of effects that the robot file names
    """
    path = Path(path)
    try:
        table = Table(tomllib.loads(path.read_text(encoding="utf-8")), "")
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: not a TOML file ({error})") from None
    try:
        return _plan(table, path.parent, parameters or {}, allow_effects)
    except (StudyError, RobotError, ExperimentError) as error:
        raise type(error)(f"{path}: {error}") from None


def _plan(table: Table, folder: Path, parameters: Mapping[str, float], allow_effects: bool) -> StudyPlan:
    model, values = _model(str(table.get("model")), folder, parameters, allow_effects)
    experiment = _experiment(model, str(table.get("experiment")), folder)
    design = str(table.get("design", "latin_hypercube"))
    if design not in ("grid", *_SAMPLED):
        raise StudyError(f"design is {design!r}; known are grid, {', '.join(_SAMPLED)}")
    runs = table.whole(table.get("runs", _RUNS), "runs", 1, 10_000_000)
    seed = table.whole(table.get("seed", 0), "seed", 0, 2**32 - 1)
    metrics = _metrics(table.get("metrics", list(METRICS)), folder)
    levels = _levels(table.table("parameters"), values)
    table.done()
    if design == "grid":
        ranges = {name: (min(v), max(v)) for name, v in levels.items()}
        return StudyPlan(model, experiment, ranges, grid(levels), None, metrics)
    ranges = {name: _range(name, v) for name, v in levels.items()}
    method = next((m for m in get_args(Method) if m == design), None)
    return StudyPlan(model, experiment, ranges, _SAMPLED[design](ranges, runs, seed), method, metrics)


def _model(
    name: str, folder: Path, parameters: Mapping[str, float], allow_effects: bool
) -> tuple[Robot | Path, Mapping[str, float]]:
    """The model and the values of its parameters, which only a robot tells."""
    beside = folder / name
    if name.endswith(".fmu"):
        if parameters:
            raise StudyError("an FMU keeps its own values; name the others in the plan's [parameters]")
        return beside, {}
    robot = load_robot(beside if beside.is_file() else name, allow_effects)
    robot = robot.with_parameters(parameters, robot.name)
    return robot, robot.parameters


def _experiment(model: Robot | Path, name: str, folder: Path) -> Experiment:
    beside = folder / name
    name = str(beside) if beside.is_file() else name
    if isinstance(model, Robot):
        return load_experiment(model, name)
    return read_experiment(name, fmu_joints(model))


def _levels(table: Table, values: Mapping[str, float]) -> dict[str, list[float]]:
    """Values of every parameter that a pattern names; a share is taken of the robot's own value."""
    levels: dict[str, list[float]] = {}
    for pattern in table.data:
        for name in _named(pattern, values):
            levels[name] = _values(table.data[pattern], table.place(pattern), values.get(name))
    if not levels:
        raise StudyError("[parameters] is empty; name at least one")
    return levels


def _named(pattern: str, values: Mapping[str, float]) -> Sequence[str]:
    if not values:
        return [pattern]
    found = [name for name in values if fnmatch.fnmatchcase(name, pattern.replace("[", "[[]"))]
    if not found:
        raise StudyError(f"parameters.{pattern} names no parameter of the robot")
    return found


def _values(given: Any, place: str, own: float | None) -> list[float]:
    if isinstance(given, list) and given:
        return [number(v, place) for v in given]
    share = number(given, place, lower=0.0)
    if own is None:
        raise StudyError(f"{place} is a share of a value that an FMU file does not tell; give [from, to]")
    return [own - share * abs(own), own + share * abs(own)]


def _range(name: str, values: list[float]) -> tuple[float, float]:
    if len(values) != 2 or not values[0] < values[1]:
        raise StudyError(f"parameters.{name} must be [from, to] with from < to, not {values}")
    return values[0], values[1]


def _metrics(names: Any, folder: Path) -> dict[str, Metric]:
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise StudyError("metrics must be a list of names")
    return dict(_metric(name, folder) for name in names)


def _metric(name: str, folder: Path) -> tuple[str, Metric]:
    """A metric that ships, or FILE.py:FUNCTION."""
    if name in METRICS:
        return name, METRICS[name]
    file, _, function = name.rpartition(":")
    if not file.endswith(".py") or not (folder / file).is_file():
        raise StudyError(f"unknown metric {name!r}: give FILE.py:FUNCTION, or one of {', '.join(METRICS)}")
    spec = importlib.util.spec_from_file_location(Path(file).stem, folder / file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if not callable(getattr(module, function, None)):
        raise StudyError(f"{folder / file} has no function {function}")
    return function, getattr(module, function)
