"""Everything that is checked of a log before it is believed, by every command alike."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.coordinate import is_motor, joint_number, motor_of, reference_of
from flexmodels.robot import Robot, RobotError
from pyident.checks.another_machine import another_machine
from pyident.checks.balances import Balances, balances, samples
from pyident.checks.better_channels import better_channels, constants, unexplained
from pyident.checks.changes import changes
from pyident.checks.channels.commands import commands
from pyident.checks.channels.every_channel import channels
from pyident.checks.defect import Defect
from pyident.checks.gravity import gravity
from pyident.checks.scale import scale
from pyident.checks.signs import signs
from pyident.checks.timing import all_late, timing
from pyident.checks.twists import bends, twists
from pyident.checks.whole_log import whole_log
from pyident.estimation.lock_unlogged import locked
from pyident.kinematics.structure import ReachError, StructureError
from pyident.logs.disk import LogFile
from pyident.logs.log import Log, LogError
from pyident.rules.channel_checks import CHANNELS

_WINDOW = 20_000  # rows of a log on disk that are looked at
_NAMED = 3  # logs or channels in a refusal
_BREAKING = ("jump", "wrapped", "stuck", "rows", "rate", "constant", "same", "time")


@dataclass(frozen=True)
class CheckedLogs:
    """What the checks say of logs; `warnings` are the sentences on all that was not refused."""

    defects: tuple[Defect, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        return tuple(defect.sentence for defect in self.defects)

    def json(self) -> list[dict[str, str]]:
        return [defect.json() for defect in self.defects]


def checked(robot: Robot, logs: Sequence[Log | LogFile], force: bool = False) -> CheckedLogs:
    """The defects of logs. Raises LogError for a gross one unless `force`, RobotError as `check_log`."""
    looked = [_looked_at(robot, _in_memory(robot, log)) for log in logs]
    listed = [defect for one in looked for defect in one.defects]
    defects = tuple(defect for defect in listed if not _contradicted(defect, listed, len(logs)))
    gross = [defect for defect in defects if defect.severity == "gross"]
    if gross and not force:
        wrong = [[defect for defect in one.defects if defect.severity == "gross"] for one in looked]
        of = dict(zip(_short([one.log.source for one in looked]), wrong, strict=True))
        why = f"{gross[0].sentence}{_beside(of)}{_further_joints(listed)}"
        raise LogError(f"{why}; --force (force=True) uses the log as it is")
    if not gross and len(logs) > 1:
        defects += tuple(another_machine(_all_balances(robot, looked)))
    return CheckedLogs(defects)


def _contradicted(defect: Defect, listed: Sequence[Defect], logs: int) -> bool:
    """Whether all torques come late or early in fewer than half of the logs: one recorder delays all alike.

    What a model lacks may look like a delay along one motion.
    """
    alike = [other for other in listed if other.delays_all]
    return defect in alike and 2 * len(alike) < logs


def _short(sources: Sequence[str]) -> list[str]:
    """What tells logs apart: the names of their files, or their numbers where these are not all different."""
    names = [Path(source).name for source in sources]
    return names if len(set(names)) == len(names) else [f"log {i}" for i in range(1, len(names) + 1)]


def _beside(of: Mapping[str, Sequence[Defect]]) -> str:
    """What is grossly wrong beside the first defect: the logs that have it, too, and other channels."""
    first = next(defect for found in of.values() for defect in found)
    listed = [(log, defect) for log, found in of.items() for defect in found][1:]
    alike = [log for log, d in listed if (d.kind, d.channel) == (first.kind, first.channel)]
    others = [
        (d.channel or d.kind) + (f" in {log}" if len(of) > 1 else "")
        for log, d in listed
        if (d.kind, d.channel) != (first.kind, first.channel)
    ]
    said = [("the same in ", list(dict.fromkeys(alike))), ("wrong, too: ", list(dict.fromkeys(others)))]
    parts = [what + _some(names) for what, names in said if names]
    return f" ({'; '.join(parts)})" if parts else ""


def _further_joints(listed: Sequence[Defect]) -> str:
    """That a log has more joints than its robot, which may be why all else seems wrong."""
    found = next((d for d in listed if d.kind == "joints"), None)
    return f"; {found.sentence.split(': ', 1)[1]}" if found else ""


def _some(names: Sequence[str]) -> str:
    """The first of some names, and how many there are beside."""
    more = len(names) - _NAMED
    return ", ".join(names[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def check_log(robot: Robot, log: Log | LogFile) -> tuple[Defect, ...]:
    """Defects of one log, gross ones first; none for a sound one.

    robot   whose joints the log should show: its limits, rates and equations are held against it
    Of torques and deformations only what is logged is judged, of a long log on disk its first rows.
    Raises LogError for a log without positions, RobotError for a robot whose closures do not fit together.
    """
    return _looked_at(robot, _in_memory(robot, log)).defects


@dataclass(frozen=True)
class _Looked:
    """What is said of a log, and its balances of a robot without what it does not hold; None: it has none."""

    log: Log
    defects: tuple[Defect, ...]
    robot: Robot
    of: Balances | None = None


def _looked_at(robot: Robot, log: Log) -> _Looked:
    missing = [motor_of(k) for k, _ in robot.numbered if motor_of(k) not in log.names]
    if missing:
        raise LogError(f"{log.source}: column {missing[0]} is missing, which robot {robot.name} needs; add "
                       "it, or "
                       f"map it under [columns] in the robot file")  # fmt: skip
    if len(log) < CHANNELS.fewest_rows:
        return _Looked(log, (), robot)
    robot, _ = locked(robot, [log])
    defects = [*whole_log(robot, log), *channels(robot, log), *commands(robot, log)]
    of = None
    if not any(d.severity == "gross" and d.kind in _BREAKING for d in defects):
        try:
            of = _balances(robot, log)
        except ReachError as error:
            sentence = f"{log.source}: {error}; check the units, signs and zeros of its positions"
            defects.append(Defect("gross", "unit", "", sentence))
        except StructureError as error:
            raise RobotError(f"robot {robot.name}: {error}") from None
    if of is not None:
        defects = _of_one_cause([*defects, *_of_the_fit(robot, log, of)])
    return _Looked(log, tuple(sorted(defects, key=lambda d: d.severity != "gross")), robot, of)


def _of_one_cause(defects: Sequence[Defect]) -> list[Defect]:
    """Without wrong signs of a joint whose angle seems to have another unit: that is gross in their place."""
    of = {d.channel: joint_number(d.channel) for d in defects if d.kind in ("unit", "sign") and d.channel}
    units = {of[d.channel] for d in defects if d.kind == "unit" and is_motor(d.channel)}
    signs = {of[d.channel] for d in defects if d.kind == "sign" and d.channel} & units
    kept = [d for d in defects if d.kind != "sign" or of.get(d.channel) not in units]
    cause = [d.kind == "unit" and of.get(d.channel) in signs for d in kept]
    return [replace(d, severity="gross") if gross else d for d, gross in zip(kept, cause, strict=True)]


def _of_the_fit(robot: Robot, log: Log, of: Balances) -> list[Defect]:
    """What a quick fit of the balances says of the channels."""
    source = log.source
    weight = list(gravity(of, source))
    if any(defect.severity == "gross" for defect in weight):
        return weight
    order = list(better_channels(of, source))
    if any(defect.severity == "gross" for defect in order):
        return order
    if late := list(timing(of, source)):
        return [*order, *late, *scale(of, source)]
    checks = (signs, twists, bends, scale, unexplained, all_late)
    found = [defect for check in checks for defect in check(of, source)]
    return [*order, *weight, *found, *constants(of, robot, source), *changes(of, log)]


def _balances(robot: Robot, log: Log) -> Balances | None:
    """None of a log without torques, or with some: then the regression asks for the others. Raises
    StructureError.
    """
    signals = samples(_with_constants(robot), log)
    if signals is None or not np.isfinite(signals.tau).all():
        return None
    try:
        return balances(signals)
    except StructureError:
        raise
    except ValueError:  # a law that needs a signal of its own
        return None


def _all_balances(robot: Robot, looked: Sequence[_Looked]) -> list[tuple[str, Balances]]:
    """Source and balances, all of one robot, of those logs that have any."""
    robot, _ = locked(robot, [one.log for one in looked])
    listed = [one for one in looked if one.of is not None]
    found = ((o.log.source, o.of if o.robot == robot else _balances(robot, o.log)) for o in listed)
    return [(source, of) for source, of in found if of is not None]


def _with_constants(robot: Robot) -> Robot:
    """The robot with a constant torque at every joint: amplifiers and sensors have zeros of their own."""
    for k, joint in robot.numbered:
        if "offset" not in joint.values:
            robot = robot.with_effect(k, "offset")
    return robot


def _in_memory(robot: Robot, log: Log | LogFile) -> Log:
    if isinstance(log, Log):
        return log
    signals = [*robot.coordinates, *robot.torques, *(reference_of(k) for k, _ in robot.numbered)]
    names = ["time", *(name for name in signals if name in log.names)]
    window = next(log.windows(names, _WINDOW, 0))
    return Log(pd.DataFrame(window.values[window.own], columns=names), log.source, log.notes)
