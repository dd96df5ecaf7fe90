"""Logs -> parameters."""

from collections.abc import Callable

from flexmodels.robot import Robot
from pyident.estimation.identify import Identified
from pyident.estimation.identify import identify as regress
from pyident.logs.log import Log
from pyident.refinement.output_error import output_error
from pyident.refinement.remove_bias import correct_by_replicas
from pyident.simulation.fmu_runs import FmuRuns
from pyident.verbs.fitted import Fit
from pyident.verbs.inputs import Columns, Logs, Model, given, opened, robot_of, simulable

Progress = Callable[[float], None]


def identify(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    robust: bool = False,
    allow_effects: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """Every dynamic parameter of a robot from its logs; the model's own values are never used.

    model     a Robot, a shipped robot's name, or the path of a robot file
    logs      a Log, the path of one, a DataFrame with the columns of a log (SI units), or a list of these
    mapping   names, units and signs of the logs' columns (a Mapping or its file)
    robust    give single equations that stick out less weight (Huber)
    progress  called with the fraction done
    Hinges that the logs say nothing of are locked, which `notes` says. Raises RobotError, LogError.
    """
    read = opened(robot_of(model, allow_effects=allow_effects), logs, mapping)
    found = regress(read.robot, read.logs, robust=robust)
    if progress:
        progress(1.0)
    return Fit(found, read.notes)


def refine(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    allow_effects: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """Like `identify`, and on until the simulated robot follows its logs (output error; a minute or so).

    The robot needs its controller and the logs their references. Raises RobotError, LogError,
    SimulationError.
    """
    read = given(simulable(robot_of(model, allow_effects=allow_effects)), logs, mapping)
    return Fit(_refined(read.robot, list(read.logs), progress or (lambda _: None)), read.notes)


def _refined(robot: Robot, logs: list[Log], progress: Progress) -> Identified:
    """Regression, its bias removed by replicas, then output error."""
    with FmuRuns(robot) as runs:
        start = correct_by_replicas(robot, logs, runs, lambda share: progress(0.3 * share))
        return output_error(robot, logs, start, runs, progress=lambda s: progress(0.3 + 0.7 * s))[0]
