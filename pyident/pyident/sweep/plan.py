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
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any, get_args

import pandas as pd

from flexmodels.effects.law_names import EffectError
from flexmodels.effects.trust import allowed_file, code_allowed
from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot
from flexmodels.files.toml_table import Table, number, read_toml
from flexmodels.robot import Robot, RobotError
from pyident.simulation.fmu_runs import fmu_joints
from pyident.simulation.references import ExperimentError, load_experiment, read_experiment
from pyident.sweep.metrics import METRICS, Metric
from pyident.sweep.sampling import Ranges, grid, latin_hypercube, sobol
from pyident.sweep.sensitivity import Method, morris_design, sobol_indices_design
from pyident.sweep.store import StudyError

MOST_RUNS = 10_000_000
_RUNS = 200
_LARGEST = 200_000_000  # numbers of a design
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
    path: str | Path,
    parameters: Mapping[str, float] | None = None,
    allow_effects: bool = False,
    most: int = MOST_RUNS,
) -> StudyPlan:
    """Read a plan; files that it names are beside it. Raises StudyError, RobotError, ExperimentError.

    parameters      values that replace the robot's own, before the plan's shares are taken of them
    allow_effects   run the Python files of effects and metrics that robot file and plan name
    most            runs that the design is cut to (`planned_runs` says how many the plan asks for)
    """
    path = Path(path)
    try:
        with code_allowed() if allow_effects else nullcontext():
            return _plan(Table(read_toml(path), ""), path.parent, parameters or {}, most)
    except EffectError as error:
        raise StudyError(f"{path}: {error}") from None
    except (StudyError, RobotError, ExperimentError) as error:
        raise type(error)(f"{path}: {error}") from None


def planned_runs(path: str | Path) -> int:
    """How many runs a plan asks for, without reading anything else of it. Raises RobotError, StudyError."""
    data = read_toml(Path(path))
    if data.get("design") != "grid":
        return _runs(Table(data, ""))
    ranges = data.get("parameters")
    levels = ranges.values() if isinstance(ranges, dict) else ()
    return prod(len(values) if isinstance(values, list) else 2 for values in levels)


def _runs(table: Table) -> int:
    return table.whole(table.get("runs", _RUNS), "runs", 1, MOST_RUNS)


def _plan(table: Table, folder: Path, parameters: Mapping[str, float], most: int) -> StudyPlan:
    model, values = _model(table.text("model"), folder, parameters)
    experiment = _experiment(model, table.text("experiment"), folder)
    design = table.text("design", "latin_hypercube")
    if design not in ("grid", *_SAMPLED):
        raise StudyError(f"design is {design!r}; known are grid, {', '.join(_SAMPLED)}")
    runs = min(_runs(table), most)
    seed = table.whole(table.get("seed", 0), "seed", 0, 2**32 - 1)
    metrics = _metrics(table.get("metrics", list(METRICS)), folder)
    levels = _levels(table.table("parameters"), values)
    table.done()
    if design == "grid":
        ranges = {name: (min(v), max(v)) for name, v in levels.items()}
        return StudyPlan(model, experiment, ranges, grid(_few(levels, most)), None, metrics)
    ranges = {name: _range(name, v) for name, v in levels.items()}
    if runs * len(ranges) > _LARGEST:
        raise StudyError(f"{runs} runs of {len(ranges)} parameters are too many for memory; plan fewer")
    method = next((m for m in get_args(Method) if m == design), None)
    return StudyPlan(model, experiment, ranges, _SAMPLED[design](ranges, runs, seed), method, metrics)


def _few(levels: Mapping[str, list[float]], most: int) -> dict[str, list[float]]:
    """Values of a grid; a single one of each where there would be more combinations than `most`."""
    count = prod(len(values) for values in levels.values())
    if count > MOST_RUNS:
        raise StudyError(f"the grid has {count:.3g} runs, {MOST_RUNS:g} are the most; take fewer values")
    return {name: values if count <= most else values[:1] for name, values in levels.items()}


def _model(
    name: str, folder: Path, parameters: Mapping[str, float]
) -> tuple[Robot | Path, Mapping[str, float]]:
    """The model and the values of its parameters, which only a robot tells."""
    beside = folder / name
    if name.endswith(".fmu"):
        if parameters:
            raise StudyError("an FMU keeps its own values; name the others in the plan's [parameters]")
        return beside, {}
    robot = load_robot(beside if beside.is_file() else name)
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
        raise StudyError(f"{place} is a share of a value that an FMU file does not state; give [from, to]")
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
    if not file.endswith(".py"):
        raise StudyError(f"unknown metric {name!r}: give FILE.py:FUNCTION, or one of {', '.join(METRICS)}")
    path = allowed_file(file, folder, "--allow-effects")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        words = " ".join(f"{type(error).__name__}: {error}".split())
        raise StudyError(f"metric {name}: {path} cannot be read ({words})") from None
    if not callable(getattr(module, function, None)):
        raise StudyError(f"{path} has no function {function}")
    return function, getattr(module, function)
