"""Files of one recording -> the mapping that they want, and the questions that only their owner answers."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from flexmodels.robot import Robot
from pyident.inspection.channel import PLACE, Channel
from pyident.inspection.clock import gap, grows_evenly, no_clock, starts_again, without_repeats
from pyident.inspection.drives import knows_drive, of_its_drive
from pyident.inspection.guesses import NAME, first_guesses, si
from pyident.inspection.motion import with_motion_units, with_velocities_found, with_whole_turns
from pyident.inspection.nameless import DERIVATIVE, nameless
from pyident.inspection.of_one_kind import of_one_kind, whole
from pyident.inspection.physics import EXPLAINS, with_physics
from pyident.inspection.proposal import Proposal
from pyident.inspection.words import meaning
from pyident.logs.formats.read import read_recording
from pyident.logs.formats.recording import Recording
from pyident.logs.log import LogError
from pyident.logs.mapping import Mapping, Source
from pyident.logs.steps import usual_step
from pyident.logs.units import FACTORS, KINDS

_LARGEST = 1e100  # in whatever unit
_ROUNDED = 1e-3  # of a column's range: how far rounding takes one from the same in another unit
_EFFORTS = ("torque", "current", "voltage")


def inspect_log(
    files: Sequence[str | Path], robot: Robot | None = None, rate: float | None = None
) -> Proposal:
    """Guess signals, joints, units, signs, offsets and delays of every column.

    files   parts of one recording, or, where their columns are the same, recordings of one kind
    robot   whose joints' names, limits and equations are witnesses
    rate    [Hz], for files without a column of time
    Raises LogError.
    """
    if not files:
        raise LogError("there is no file; give one or more of one recording")
    read = [(Path(file), read_recording(Path(file))) for file in files]
    if len({frozenset(recording.columns) for _, recording in read}) == 1:
        each = [_proposal([part], robot, rate) for part in read]
        if whole(each[0], robot):
            return of_one_kind(each)
    return _proposal(read, robot, rate)


def certain_mapping(files: Sequence[str | Path], robot: Robot | None = None) -> Mapping:
    """The mapping of columns that speak for themselves, as those of a log do: their units are its own.

    Raises LogError where a question is left.
    """
    found = inspect_log(files, robot)
    if all(c.column in (c.name, c.signal) for c in found.channels):
        return Mapping({c.column: Source(c.column) for c in found.channels})
    if found.questions:
        source = ", ".join(map(str, files))
        cure = "give the mapping that `pyident log inspect` writes, answered, by --mapping"
        raise LogError(f"{source}: {found.questions[0]}; {cure}")
    return found.mapping


def _proposal(read: list[tuple[Path, Recording]], robot: Robot | None, rate: float | None) -> Proposal:
    recording, notes = _measured(_joined(read))
    recording, said = without_repeats(recording)
    notes += said + _in_turns(recording)
    channels = [with_whole_turns(c) for c in first_guesses(recording, robot)]
    notes += [f"{c.column} jumps by whole turns: unwrap = true joins it" for c in channels if c.turn]
    time = next((c for c in channels if c.signal == "time"), None)
    period = _period(time) if time is not None else 1 / rate if rate else None
    notes += gap(time) if time is not None else ()
    channels = nameless(channels, robot, period)
    channels = with_velocities_found(with_motion_units(channels, robot, period), period)
    channels = _one_each(channels, robot)
    if robot is not None and (time is not None or rate):
        channels, further = with_physics(channels, recording.columns, robot, rate)
        notes += further
    explained = _explained(channels)
    channels = [_asked(c, robot) if c.name is not None else _unnamed(c) for c in channels]
    channels = channels if explained else [_placed(c) for c in channels]
    joints = len(robot.joints) if robot else max((c.joint or 0 for c in channels if c.name), default=0)
    questions = (*_missing(channels, robot, joints, time, rate), *(c.doubt for c in channels if c.doubt))
    return Proposal(
        files=tuple(str(path) for path, _ in read),
        channels=tuple(channels),
        rate=None if time else rate,
        header=recording.header,
        joints=joints,
        notes=tuple(notes),
        questions=questions,
    )


def _joined(read: list[tuple[Path, Recording]]) -> Recording:
    if len(read) == 1:
        return read[0][1]
    count = Counter(name for _, recording in read for name in recording.columns)
    columns, units, clocks = {}, {}, {}
    for path, recording in read:
        own = {n: n if count[n] == 1 else f"{path.stem}:{n}" for n in recording.columns}
        columns |= {own[n]: x for n, x in recording.columns.items()}
        units |= {own[n]: unit for n, unit in recording.units.items()}
        clocks |= {own[n]: own[clock] for n, clock in recording.clocks.items()}
        clock = _own_clock(read[0][1], recording)
        clocks |= {
            own[n]: own[clock] for n in recording.columns if clock and n not in (clock, *recording.clocks)
        }
    notes = tuple(f"{path}: {note}" for path, recording in read for note in recording.notes)
    texts = tuple(name for _, recording in read for name in recording.texts)
    return Recording(columns, units, clocks, all(r.header for _, r in read), notes, texts)


def _own_clock(first: Recording, other: Recording) -> str | None:
    """The column of a further file that counts its time, where that is another than the first one's."""
    clocks = [n for n, x in other.columns.items() if meaning(n).signal == "time" and grows_evenly(x)]
    clocks = [n for n in clocks if n not in other.clocks.values()]
    if not clocks or (same := first.columns.get(clocks[0])) is None:
        return None
    return None if np.array_equal(same, other.columns[clocks[0]]) else clocks[0]


def _measured(recording: Recording) -> tuple[Recording, list[str]]:
    """Without columns that no sensor can have measured, and a note on each, and on what was not read."""
    said = list(recording.notes)
    if recording.texts:
        said.append(f"left out, as they hold words and no numbers: {', '.join(recording.texts)}")
    notes = {}
    for name, x in recording.columns.items():
        if not np.isfinite(x).any():
            notes[name] = f"{name} is left out: it holds no number"
        elif np.nanmax(np.abs(x)) > _LARGEST:
            notes[name] = f"{name} is left out: no sensor measures values beyond {_LARGEST:g}"
    kept = {name: x for name, x in recording.columns.items() if name not in notes}
    clocks = {name: clock for name, clock in recording.clocks.items() if name in kept and clock in kept}
    return replace(recording, columns=kept, clocks=clocks), [*said, *notes.values()]


def _in_turns(recording: Recording) -> list[str]:
    """A note where a column has several values for each time: of several joints, one after the other."""
    times = [name for name in recording.columns if meaning(name).signal == "time" and not recording.clocks]
    if not times:
        return []
    count = len(recording.columns[times[0]])
    longer = {n: len(x) // count for n, x in recording.columns.items() if count and not len(x) % count}
    longer = {n: ratio for n, ratio in longer.items() if ratio > 1}
    if not longer:
        return []
    name, ratio = next(iter(longer.items()))
    each = f"{name} holds {ratio * count} values, {ratio} for each of the {count} of {times[0]}"
    return [f"{each}: if those of {ratio} joints take turns, make a column of each"]


def _period(time: Channel) -> float:
    return usual_step(time.values) * FACTORS[time.unit or "s"]


def _one_each(channels: list[Channel], robot: Robot | None) -> list[Channel]:
    """One column per signal of the robot's joints, and a question where its choice has no witness."""
    joints = len(robot.joints) if robot is not None else None
    if joints is not None:
        none = {"signal": "other", "joint": None, "doubt": ""}
        channels = [replace(c, **none) if (c.joint or 0) > joints else c for c in channels]
    turning = {c.joint for c in channels if c.signal == "position" and KINDS.get(c.unit or "") == "angle"}
    owners: dict[str, Channel] = {}
    for c in sorted(channels, key=lambda c: _rank(c, turning)):
        if c.name is not None:
            owners.setdefault(c.name, c)
    return [_owned(c, owners[c.name], turning) if c.name is not None else c for c in channels]


def _rank(c: Channel, turning: set[int | None]) -> tuple[bool, bool, bool, int]:
    """Of columns for one signal: those that their names tell, the measured, a torque before a current.

    turning   the joints that turn, of which a force is no torque
    """
    guessed = not any(why.startswith(NAME) for why in c.why)
    force = c.unit in ("N", "kN") and c.joint in turning
    return guessed, c.wanted, force, _EFFORTS.index(c.signal) if c.signal in _EFFORTS else 0


def _unnamed(c: Channel) -> Channel:
    return replace(c, doubt="") if c.signal in ("velocity", "acceleration") else c


def _owned(c: Channel, owner: Channel, turning: set[int | None]) -> Channel:
    """The channel of a signal, or none where another column is taken for it."""
    if c.column == owner.column:
        return c
    if _rank(c, turning) > _rank(owner, turning) or _same(c, owner):
        return replace(c, signal="other", sure=False, doubt="", why=(*c.why, f"{owner.column} is taken"))
    return replace(c, signal="other", sure=False, doubt=f"{c.column} and {owner.column} both look like "
                   f"{c.name}: {owner.column} is taken; is that right?")  # fmt: skip


def _same(c: Channel, other: Channel) -> bool:
    """Whether a column is another one again, or the same in another unit."""
    x, y = si(c), si(other)
    return x.shape == y.shape and bool(np.abs(x - y).max() <= _ROUNDED * np.ptp(y))


def _explained(channels: list[Channel]) -> bool:
    """Whether the robot's equations account for the torques, so that every joint is where it seems to be."""
    return any(EXPLAINS in why for c in channels for why in c.why)


def _placed(c: Channel) -> Channel:
    """With a question where only a column's place says what it is, or of which joint."""
    if c.name is None or not set(c.guessed) - ({PLACE} if DERIVATIVE in c.why else set()):
        return c
    asked = f"is {c.column} really {c.name}? only {c.guessed[0]} says so"
    further = c.doubt and not c.doubt.startswith(f"is {c.column} really")
    return replace(c, sure=False, doubt=f"{c.doubt}; and {asked}" if further else asked)


def _asked(c: Channel, robot: Robot | None) -> Channel:
    if robot is not None and knows_drive(robot, c):
        return replace(c, sure=True, doubt="", why=(*c.why, "the drive that the robot file gives"))
    if c.signal in ("current", "voltage"):
        return replace(c, sure=False, doubt=of_its_drive(c))
    if c.signal == "torque" and c.wanted:
        asked = f"{c.column} was commanded, not measured: does the drive give what it is told, and at once?"
        return replace(c, sure=False, doubt=f"{c.doubt}; and {asked}" if c.doubt else asked)
    if c.doubt or c.sure:
        return c
    if c.signal in ("switch", "deformation"):
        return replace(c, sure=True)
    if c.signal in ("torque", "feedforward") and c.unit is not None:
        return replace(c, sure=True)
    if c.signal in ("torque", "feedforward"):
        return replace(
            c, doubt=f"what is the unit of {c.column} (N m?), and is it of the joint or of the motor?"
        )
    return replace(c, doubt=f"is {c.column} really {c.name} in {c.unit or 'SI'}?")


def _missing(
    channels: list[Channel], robot: Robot | None, joints: int, time: Channel | None, rate: float | None
) -> list[str]:
    again = next(filter(None, map(starts_again, channels)), None) if time is None else None
    asked = [again] if again else []
    if time is None and not rate and not again:
        why = "; ".join(filter(None, map(no_clock, channels))) or "no column looks like time"
        asked.append(f"{why}: how many samples a second were recorded? (rate)")
    return [*asked, *_without_position(channels, joints), *_without_torque(channels, robot, joints)]


def _without_position(channels: list[Channel], joints: int) -> list[str]:
    places = {c.joint for c in channels if c.signal == "position" and c.name}
    lacking = [k for k in range(1, joints + 1) if k not in places]
    loose = [c.column for c in channels if c.signal == "position" and c.joint is None]
    if loose and (lacking or joints == 0):
        return [_of_which_joint(loose, "position", len(lacking))]
    if joints == 0:
        return [
            "no column looks like the position of a joint: which are they? a robot file (--robot) helps, and "
            "where no column is a time, their rate (--rate)"
        ]
    return [f"no column looks like the position of joint {k}: which is it?" for k in lacking]


def _without_torque(channels: list[Channel], robot: Robot | None, joints: int) -> list[str]:
    drives = robot is not None and (robot.servo or robot.controller)  # they tell the torque
    efforts = {c.joint for c in channels if c.signal in _EFFORTS and c.name}
    served = {c.joint for c in channels if c.signal == "reference" and c.name} if drives else set()
    lacking = [k for k in range(1, joints + 1) if k not in efforts and k not in served]
    loose = [c.column for c in channels if c.signal in _EFFORTS and c.joint is None]
    if not lacking:
        return []
    if loose:
        return [_of_which_joint(loose, "torque", len(lacking))]
    if robot is None or len(lacking) < joints:
        return [f"no column looks like the torque of joint {lacking[0]}: which is it?"]
    return ["no column looks like a torque: which is it, or does the robot file describe the drives?"]


def _of_which_joint(columns: list[str], what: str, lacking: int) -> str:
    """The question of columns that no name gives to a joint; lacking: how many are looked for."""
    one = len(columns) == 1
    said = f"{', '.join(columns)} {f'looks like a {what}' if one else f'look like {what}s'}"
    needed = f"; {lacking} {what}s are needed" if lacking > len(columns) else ""
    return f"{said}, but of which joint{'' if one else 's'}? no name says so{needed}"
