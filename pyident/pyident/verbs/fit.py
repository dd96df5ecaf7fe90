"""Logs -> parameters."""

from collections.abc import Callable
from dataclasses import replace

from flexmodels.robot import RobotError
from pyident.estimation.identify import Identified, near, without_intervals
from pyident.estimation.identify import identify as regress
from pyident.logs.log import Log
from pyident.refinement.estimators import DEFAULT, ESTIMATORS, refined
from pyident.simulation.fmu_runs import FmuRuns
from pyident.verbs.fitted import Fit
from pyident.verbs.inputs import Columns, Logs, Model, Opened, given, opened, robot_of, simulable

Progress = Callable[[float], None]


def identify(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    robust: bool = False,
    estimator: str = DEFAULT,
    prior: Model | None = None,
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """Every dynamic parameter of a robot from its logs; the model's own values are never used.

    model     a Robot, a shipped robot's name, or the path of a robot file
    logs      a Log, the path of one, a DataFrame with the columns of a log (SI units), or a list of these
    mapping   names, units and signs of the logs' columns (a Mapping or its file)
    robust    give single equations that stick out less weight (Huber): the estimator `irls`
    estimator "iv" (instruments from the simulated model), "oe" (output error), "wls", "ols", "irls", "tls"
    prior     a model of the same arm, from CAD or URDF: near its bodies stays what the data leave open
    force     take logs that the checks call grossly wrong; else they raise LogError, and lesser doubts are
              in `notes`
    progress  called with the fraction done
    Hinges that the logs say nothing of are locked, which `notes` says. Raises RobotError, LogError.
    """
    read = opened(robot_of(model, allow_effects=allow_effects), logs, mapping, force)
    found = _identified(read, "irls" if robust else estimator, progress)
    if prior is not None:
        found = near(found, robot_of(prior, allow_effects=allow_effects))
    if progress:
        progress(1.0)
    return Fit(found, (*read.notes, *found.notes))


def refine(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """Like `identify`, and on until the simulated robot follows its logs (output error; a minute or so).

    The robot needs its controller and the logs their references. Raises RobotError, LogError,
    SimulationError.
    """
    read = given(simulable(robot_of(model, allow_effects=allow_effects)), logs, mapping, force=force)
    found = refined(read.robot, list(read.logs), FmuRuns, progress)
    return Fit(found, (*read.notes, *found.notes))


def _identified(read: Opened, name: str, progress: Progress | None) -> Identified:
    if name not in ESTIMATORS:
        raise RobotError(f"there is no estimator {name}; there are {', '.join(ESTIMATORS)}")
    logs = [log for log in read.logs if isinstance(log, Log)]
    if len(logs) == len(read.logs):
        return ESTIMATORS[name](read.robot, logs, FmuRuns, progress)
    found = without_intervals(regress(read.robot, read.logs, robust=name == "irls"))
    note = "a log this long is gone through on disk, by weighted least squares and without intervals"
    return replace(found, notes=(note,))
