"""What a caller gives: a model and logs in any of their forms; every verb reads both here."""

from collections.abc import Callable, Iterable, Sequence
from collections.abc import Mapping as Named
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import pandas as pd

from flexmodels.files.robot_file import load_robot
from flexmodels.named_values import with_settings
from flexmodels.robot import Robot, RobotError
from pyident.checks.check_log import check_log as defects_of
from pyident.checks.check_log import checked
from pyident.checks.defect import Defect
from pyident.conditioning.own_cutoff import with_own_cutoff
from pyident.conditioning.standing import standing
from pyident.estimation.lock_unlogged import locked, locked_note, without_loop
from pyident.logs.averaged import averaged
from pyident.logs.disk import LogFile
from pyident.logs.foreign import at_joints, import_log, map_frame, open_robot_log, robot_log
from pyident.logs.log import Log, LogError, renamed
from pyident.logs.log import read_log as read_plain
from pyident.logs.mapping import Mapping, read_mapping
from pyident.refinement.instruments.stand_in import driven
from pyident.refinement.loop_torque import with_loop_torque
from pyident.simulation.denoised import denoises
from pyident.verbs.fmu.arguments import is_fmu

Model = Robot | str | Path
Data = Log | LogFile | pd.DataFrame | str | Path
Logs = Data | Sequence[Data]
Columns = Mapping | str | Path
Hinges = Named[int, Named[str, float]]


@dataclass(frozen=True)
class Given:
    """A robot as far as its logs can tell of it, the logs, those held out, notes on all of them and their
    defects.

    hinges   by joint, from 1, the `k[1]`, `d[1]` and `J_m` that its motor tells, as rigid drives have none
    """

    robot: Robot
    logs: tuple[Log, ...]
    heldout: tuple[Log, ...]
    notes: tuple[str, ...]
    defects: tuple[Defect, ...]
    hinges: Hinges = field(default_factory=dict)


@dataclass(frozen=True)
class Opened:
    """The same for a regression, which reads long logs from disk, window by window."""

    robot: Robot
    logs: tuple[Log | LogFile, ...]
    heldout: tuple[Log, ...]
    notes: tuple[str, ...]
    defects: tuple[Defect, ...] = ()
    hinges: Hinges = field(default_factory=dict)


Read = TypeVar("Read", Given, Opened)


def read_log(
    path: str | Path,
    robot: Model | None = None,
    mapping: Columns | None = None,
    *,
    allow_effects: bool = False,
) -> Log:
    """Read a log (CSV, Parquet, MAT; others through a mapping) under our names and in SI units.

    path      of the file
    robot     whose [columns] name the file's columns and whose transmission refers motors to joints
    mapping   names, units and signs of the columns (a Mapping or its file)
    The others as in `identify`. Raises LogError, RobotError.
    """
    columns = mapping_of(mapping)
    if robot is not None:
        return robot_log(path, robot_of(robot, allow_effects=allow_effects), columns)
    return import_log([path], columns) if columns else read_plain(path)


def check_log(
    model: Model, logs: Logs, *, mapping: Columns | None = None, allow_effects: bool = False
) -> tuple[Defect, ...]:
    """Defects of logs, gross ones of each first; none for sound ones.

    model   whose joints the logs should show: its limits, rates and equations are held against them
    The others as in `identify`; of torques and deformations only what is logged is judged. Raises LogError
    for a log without positions, RobotError for a robot whose closures do not fit together.
    """
    robot = robot_of(model, allow_effects=allow_effects)
    read = read_logs(robot, logs, mapping_of(mapping))
    return tuple(defect for log in read for defect in defects_of(robot, log))


def robot_of(model: Model, parameters: Named[str, float] | None = None, allow_effects: bool = False) -> Robot:
    """A robot, a shipped name or a file, with some parameters set to other values. Raises RobotError."""
    if is_fmu(model):
        raise RobotError(
            f"{model} is an FMU, no robot file; call identify_fmu, compare_fmu or diagnose_fmu with it"
        )
    if not isinstance(model, Model):
        raise RobotError(
            f"{model!r} is no robot; give a Robot, a shipped robot's name or a robot file's path"
        )
    robot = model if isinstance(model, Robot) else load_robot(model, allow_effects)
    return with_settings(robot, parameters) if parameters else robot


def simulable(robot: Robot, remedy: str = "add one") -> Robot:
    """The robot itself. Raises RobotError, with what to do, where nothing drives its joints."""
    if not driven(robot):
        raise RobotError(
            f"robot {robot.name} has no [controller] and no [servo], so it cannot be simulated; {remedy}"
        )
    return robot


def given(
    robot: Robot, logs: Logs, mapping: Columns | None = None, heldout: Logs = (), force: bool = False
) -> Given:
    """Read logs into memory, check them and lock the hinges that they say nothing of.

    force   take logs that are grossly wrong
    Raises LogError.
    """
    _apart(logs, heldout)
    columns = mapping_of(mapping)
    fitted = [_in_memory(log, robot, columns) for log in _listed(logs)]
    unseen = [_in_memory(log, robot, columns) for log in _listed(heldout)]
    if not fitted:
        raise LogError("there is no log; give one or more")
    _differ(fitted, unseen)
    whole = robot
    robot, notes, defects = _reduced(whole, [*fitted, *unseen], force)
    logs, modelled = with_loop_torque(robot, [*fitted, *unseen])
    robot, loop = without_loop(whole, robot)
    if denoises(robot) and not robot.settings.processing.filters:
        logs, fewer = averaged(logs)
        modelled = (*modelled, *fewer)
    return Given(robot, logs[: len(fitted)], logs[len(fitted) :], (*notes, *loop, *modelled), defects)


def opened(
    robot: Robot,
    logs: Logs,
    mapping: Columns | None = None,
    heldout: Logs = (),
    force: bool = False,
    simulates: bool = False,
) -> Opened:
    """The same, but long logs stay on disk, except those held out. Raises LogError.

    simulates   the robot keeps its controller also where hinges are locked
    """
    _apart(logs, heldout)
    columns = mapping_of(mapping)
    read = [_on_disk(log, robot, columns) for log in _listed(logs)]
    unseen = [_in_memory(log, robot, columns) for log in _listed(heldout)]
    if not read:
        raise LogError("there is no log; give one or more")
    _differ([log for log in read if isinstance(log, Log)], unseen)
    whole = robot
    robot, notes, defects = _reduced(whole, [*read, *unseen], force)
    in_memory = [log for log in (*read, *unseen) if isinstance(log, Log)]
    torques, modelled = with_loop_torque(robot, in_memory)
    known = {id(old): new for old, new in zip(in_memory, torques, strict=True)}
    robot, loop = (robot, []) if simulates else without_loop(whole, robot)
    fitted = tuple(known.get(id(log), log) for log in read)
    return Opened(robot, fitted, tuple(known[id(log)] for log in unseen), (*notes, *loop, *modelled), defects)


def as_rigid(read: Read, rigid: Callable[[Log], Log], hinges: Hinges, notes: Iterable[str]) -> Read:
    """What was read, its logs in memory as `rigid` makes them, notes in place of those on locked hinges.

    And of those on a delay of all torques, as which links that swing show.
    """
    dropped = {locked_note(k) for k in hinges}
    dropped |= {d.sentence for d in read.defects if d.delays_all}
    logs = tuple(rigid(log) if isinstance(log, Log) else log for log in read.logs)
    heldout = tuple(map(rigid, read.heldout))
    kept = (note for note in read.notes if note not in dropped)
    return replace(read, logs=logs, heldout=heldout, notes=(*notes, *kept), hinges=hinges)


def read_logs(robot: Robot, logs: Logs, mapping: Mapping | None) -> list[Log]:
    """Logs in memory, under our names, without any check. Raises LogError."""
    return [_in_memory(log, robot, mapping) for log in _listed(logs)]


def checked_logs(
    robot: Robot, logs: Logs, mapping: Columns | None, force: bool
) -> tuple[list[Log], tuple[str, ...]]:
    """Logs in memory, and what is doubtful of them. Raises LogError, for what is gross unless `force`."""
    read = read_logs(robot, logs, mapping_of(mapping))
    return read, checked(robot, read, force).warnings


def _reduced(
    robot: Robot, logs: Sequence[Log | LogFile], force: bool
) -> tuple[Robot, tuple[str, ...], tuple[Defect, ...]]:
    found = checked(robot, logs, force)
    robot, notes = locked(robot, logs)
    robot, filtered = with_own_cutoff(robot, [log for log in logs if isinstance(log, Log)])
    still = standing(robot, logs)
    of_logs = dict.fromkeys(note for log in logs for note in log.notes)  # of the mapping they share, once
    return robot, (*of_logs, *notes, *filtered, *still, *found.warnings), found.defects


def mapping_of(mapping: Columns | None) -> Mapping | None:
    """A mapping, read where it is a file. Raises LogError."""
    return mapping if mapping is None or isinstance(mapping, Mapping) else read_mapping(mapping)


def _listed(logs: Logs) -> list[Data]:
    listed = [logs] if isinstance(logs, Data) or not isinstance(logs, Iterable) else list(logs)
    for log in listed:
        if not isinstance(log, Data):
            raise LogError(
                f"{log!r} is no log; give a Log, a DataFrame, the path of a file, or a list of these"
            )
    return listed


def _apart(logs: Logs, heldout: Logs) -> None:
    """Raises LogError for a file that is to be fitted and held out as well."""
    fitted, unseen = (
        {Path(log).resolve() for log in _listed(of) if isinstance(log, str | Path)} for of in (logs, heldout)
    )
    if twice := sorted(fitted & unseen):
        raise LogError(f"{twice[0].name} is fitted and held out; hold out a log that is not fitted")


def _differ(fitted: Sequence[Log], unseen: Sequence[Log]) -> None:
    """Raises LogError for a log that is held out and, by another name, fitted as well."""
    for log in unseen:
        same = next((f for f in fitted if f.frame.equals(log.frame)), None)
        if same is not None:
            raise LogError(
                f"{log.source} is held out and holds the same as {same.source}, which is fitted; hold out a "
                "log that is not fitted"
            )


def _in_memory(log: Data, robot: Robot, mapping: Mapping | None) -> Log:
    if isinstance(log, str | Path):
        return robot_log(log, robot, mapping)
    if isinstance(log, LogFile):
        return robot_log(log.path, robot, mapping)
    frame, source = (log, "the data frame") if isinstance(log, pd.DataFrame) else (log.frame, log.source)
    if mapping is not None and not set(mapping.signals) <= set(frame):
        return map_frame(frame, mapping, source, robot)
    read = Log.from_frame(renamed(frame, robot.settings.columns, source), source)
    read = replace(read, frame=at_joints(read.frame, robot, source))
    return read if isinstance(log, pd.DataFrame) else replace(log, frame=read.frame)


def _on_disk(log: Data, robot: Robot, mapping: Mapping | None) -> Log | LogFile:
    if isinstance(log, LogFile) and mapping is None:
        return log
    return (
        open_robot_log(log, robot, mapping)
        if isinstance(log, str | Path)
        else _in_memory(log, robot, mapping)
    )
