"""Logs -> parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from flexmodels.coordinate import of_joint
from flexmodels.link import LINK_PARAMETERS
from flexmodels.named_values import settable, with_settings
from flexmodels.robot import Robot, RobotError
from pyident.estimation.estimator import reweighted, weighted
from pyident.estimation.identify import Identified, near, of_the_same_arm, with_motors, without_intervals
from pyident.estimation.identify import identify as regress
from pyident.estimation.lock_unlogged import unlocked
from pyident.estimation.residuals import torque_error
from pyident.logs.log import Log, LogError
from pyident.refinement.auxiliary_model import by_instruments
from pyident.refinement.closed_loop import ClosedLoopFit, ServoLog, fit_closed_loop
from pyident.refinement.identifications import DEFAULT, IDENTIFICATIONS
from pyident.refinement.instruments.logged import logged
from pyident.refinement.loop_torque import lacks_torque
from pyident.regression.machine.linear_algebra import one_thread
from pyident.simulation.fmu_runs import runs_here, runs_in_threads
from pyident.verbs.fitted import Fit, ServoFit
from pyident.verbs.inputs import (
    Columns,
    Logs,
    Model,
    Opened,
    Read,
    as_rigid,
    checked_logs,
    opened,
    robot_of,
    simulable,
)

Progress = Callable[[float], None]
_ROBUST = "irls"
_NEAR_ENOUGH = 10  # rounds: what a drive has is asked for again beside the laws that explain most


@one_thread()
def identify(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    robust: bool = False,
    estimator: str = DEFAULT,
    prior: Model | None = None,
    heldout: Logs = (),
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """Every dynamic parameter of a robot from its logs; the model's own values are never used.

    model     a Robot, a shipped robot's name, or the path of a robot file
    logs      a Log, the path of one, a DataFrame with the columns of a log (SI units), or a list of these
    mapping   names, units and signs of the logs' columns (a Mapping or its file)
    robust    give single equations that stick out less weight (Huber): short for the estimator "irls"
    estimator "iv" (instruments from the simulated model), "oe" (output error); regressions: "wls", "ols",
              "irls", "tls", "pe" (prediction error)
    prior     a model of the same arm, from CAD or URDF: near its bodies stays what the data leave open
    heldout   further logs, checked like the others, whose torque the written model is judged on
    allow_effects  run the Python files that the robot file names; without it only those that are trusted
    force     take logs that the checks call grossly wrong; else they raise LogError, and lesser doubts are
              in `notes`
    progress  called with the fraction done
    Hinges that no log holds are locked, which `notes` says, but for those whose stiffness the robot has and
    whose motors feel how their links swing: `notes` tells their values. Raises RobotError, LogError.
    """
    if robust and estimator not in (DEFAULT, _ROBUST):
        raise RobotError(
            f"robust is the estimator {_ROBUST}, and {estimator} was asked for; leave one of them out"
        )
    robot = robot_of(model, allow_effects=allow_effects)
    cad = None if prior is None else of_the_same_arm(robot_of(prior, allow_effects=allow_effects), robot)
    read = opened(robot, logs, mapping, heldout, force, simulates=estimator == "oe")
    in_memory = [log for log in read.logs if isinstance(log, Log)]
    if len(in_memory) == len(read.logs):
        read = on_springs(robot, read, in_memory)
    found = _identified(read, _ROBUST if robust else estimator, progress, cad)
    if read.hinges:
        found = with_motors(found, {of_joint(k, "J_m"): own["J_m"] for k, own in read.hinges.items()}, cad)
    taken = logged if by_instruments(found) else None
    errors = {log.source: torque_error(found.robot, log, taken) for log in read.heldout}
    found = replace(found, robot=replace(found.robot, controller=robot.controller))
    if progress:
        progress(1.0)
    hinged = unlocked(found.robot, read.hinges) if read.hinges else None
    return Fit(found, (*read.notes, *found.notes), read.logs, errors, cad, hinged)


def refine(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    prior: Model | None = None,
    heldout: Logs = (),
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Fit:
    """`identify` with the estimator "oe": on until the simulated robot follows its logs (a minute or so).

    The robot needs its controller and the logs their references. The others as in `identify`.
    Raises RobotError, LogError, SimulationError.
    """
    robot = simulable(robot_of(model, allow_effects=allow_effects))
    return identify(
        robot, logs, mapping=mapping, estimator="oe", prior=prior, heldout=heldout,
        allow_effects=allow_effects, force=force, progress=progress,
    )  # fmt: skip


def identify_servo(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    free: Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
    settings: Sequence[Mapping[str, float]] = (),
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> ServoFit:
    """Friction, inertia and drive of servo-driven joints from commands and positions (output error).

    model       with a [servo] table; its values are the start
    free        names to find; none: every law at the joints and what [servo] lists as `unknown`. Masses and
                inertias of links stay, as positions alone give torques only up to a factor
    parameters  known values of all logs, such as {"servo.kp": 400}
    settings    known values that differ from log to log, a mapping for each
    The others as in `identify`. Raises RobotError, LogError, SimulationError.
    """
    robot = robot_of(model, parameters, allow_effects)
    if robot.servo is None:
        raise RobotError(f"robot {robot.name} has no [servo]; describe its drives, or identify from torques")
    read, doubts = checked_logs(robot, logs, mapping, force)
    recordings = _with_settings(robot, read, settings)
    names = list(free) or _free(robot)
    unknown = [name for name in names if name not in settable(robot)]
    if unknown:
        raise RobotError(f"robot {robot.name} has no parameter {unknown[0]} that can be identified")
    with runs_here(robot) as simulate:
        found = fit_closed_loop(robot, recordings, names, simulate, progress=progress)
    if progress:
        progress(1.0)
    if not force:
        _refuse_unfollowed(robot, read[0], found)
    notes = dict.fromkeys(note for log in read for note in log.notes)
    return ServoFit(found, tuple(log.source for log in read), (*notes, *doubts))


def _refuse_unfollowed(robot: Robot, log: Log, found: ClosedLoopFit) -> None:
    """Raises LogError where no simulation comes nearer to the logs than their commands do."""
    if sum(found.error) >= sum(found.unmodelled):
        raise LogError(
            f"{log.source}: no simulation of robot {robot.name} comes nearer to the positions "
            f"({found.error[0]:.3g}) than their commands do, or a joint at rest ({found.unmodelled[0]:.3g}); "
            "check the log's columns, units, signs and clock, and what the robot file says of the servos; "
            "--force (force=True) takes what was found"
        )


def with_found_drive(
    robot: Robot,
    logs: Logs,
    mapping: Columns | None,
    force: bool,
    progress: Progress | None = None,
) -> tuple[Robot, tuple[str, ...]]:
    """The robot with what [servo] lists as `unknown` found in the logs first, and notes on it.

    Its torques follow from these values where nobody logged any. The slopes of all servos are taken at once,
    as if each moved its own joint alone. The others as in `identify`.
    """
    if robot.servo is None or not robot.servo.free:
        return robot, ()
    read, _ = checked_logs(robot, logs, mapping, force)
    if not all(lacks_torque(robot, log) for log in read):
        return robot, ()
    names, recordings = _free(robot), [ServoLog(log, {}) for log in read]
    alike: dict[str, list[str]] = {}
    for name in names:
        alike.setdefault(_kind(name), []).append(name)
    groups = list(alike.values())
    with runs_here(robot) as simulate:
        fit = fit_closed_loop(robot, recordings, names, simulate, _NEAR_ENOUGH, groups, progress)
    if not force:
        _refuse_unfollowed(robot, read[0], fit)
    found = {name: fit.values[name] for name in robot.servo.free}
    said = ", ".join(f"{name} {value:.4g}" for name, value in found.items())
    notes = [
        f"found in these logs first, as the robot file calls it unknown: {said}; all torques, and with them "
        "the values of effects, are as large as that and the masses of the robot file make them"
    ]
    bound = [name for name in found if name in fit.at_bound]
    if bound:
        notes.append(
            f"{', '.join(bound)} came out at the least value that it may have: something that is missing "
            "bends it, so that an effect named below may be another one's trace; if you know it, set it in "
            "the robot file and take it out of unknown"
        )
    return with_settings(robot, found), tuple(notes)


def on_springs(robot: Robot, read: Read, fitted: Sequence[Log]) -> Read:
    """What was read, its torques as rigid drives need them where logs show how links swing on hinges of the
    robot's file that no log holds; fitted: the logs that are to show it. Raises LogError.
    """
    from pyident.diagnosis.drives import unseen  # what a diagnosis needs, for robots that bend alone

    drives = unseen.found(robot, read.robot, fitted) if unseen.unseen(robot, read.robot) else None
    if drives is None:
        return read
    hinges = drives.hinges(fitted[0])
    return as_rigid(read, drives.rigid, hinges, unseen.hinge_notes(hinges))


def _free(robot: Robot) -> list[str]:
    """Every law at the joints and what [servo] lists as `unknown`."""
    laws = [name for name in robot.parameters if name.partition(".")[2] not in LINK_PARAMETERS]
    return laws if robot.servo is None else [*robot.servo.free, *laws]


def _kind(name: str) -> str:
    """What a parameter is, whichever joint has it; of no joint's own: its whole name."""
    joint, _, kind = name.partition(".")
    return kind if joint.startswith("joint") else name


def _with_settings(
    robot: Robot, logs: Sequence[Log], settings: Sequence[Mapping[str, float]]
) -> list[ServoLog]:
    if settings and len(settings) != len(logs):
        raise RobotError(f"{len(settings)} settings for {len(logs)} logs; give one for each log")
    known = list(settings) or [{}] * len(logs)
    for values in known:
        with_settings(robot, values)
    return [ServoLog(log, values) for log, values in zip(logs, known, strict=True)]


def _identified(read: Opened, name: str, progress: Progress | None, prior: Robot | None) -> Identified:
    if name not in IDENTIFICATIONS:
        raise RobotError(f"there is no estimator {name}; there are {', '.join(IDENTIFICATIONS)}")
    logs = [log for log in read.logs if isinstance(log, Log)]
    if len(logs) == len(read.logs):
        return IDENTIFICATIONS[name](read.robot, logs, runs_in_threads, progress, prior)
    found = regress(read.robot, read.logs, reweighted if name == _ROBUST else weighted)
    found = without_intervals(found if prior is None else near(found, prior))
    note = "a log this long is gone through on disk, by weighted least squares and without intervals"
    return replace(found, notes=(note, *found.notes))
