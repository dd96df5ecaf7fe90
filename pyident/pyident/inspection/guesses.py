"""From names and ranges to first guesses: which column is which signal of which joint, in which unit."""

import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.inspection.channel import LETTERS, ORDER, RANK, Channel
from pyident.inspection.clock import rate, same_as, time_column, time_unit
from pyident.inspection.letters import lettered, not_symbols
from pyident.inspection.words import Meaning, first_of, in_unit, meaning
from pyident.logs.formats.recording import Recording
from pyident.logs.units import FACTORS, KINDS, RATED, known_unit

NAME = "its name"
MOTOR_SIDE = " is called that of a motor and the robot file has no gears: is it at the joint? (gear)"
_STEADY = 0.15  # of its mean: within it a voltage is a supply
_NO_JOINT = ("time", "other", "unknown")
_KIND = {"position": ("angle", "length"), "reference": ("angle", "length"), "velocity": ("speed",),
         "torque": ("effort",), "feedforward": ("effort",), "current": ("electric", "none"),
         "voltage": ("electric", "none"), "time": ("time",)}  # fmt: skip
_NATURAL = {"position": ("rad", "m"), "reference": ("rad", "m"), "velocity": ("rad/s", "m/s"),
            "torque": ("N.m", "N"), "feedforward": ("N.m", "N"), "current": ("A", "A"), "voltage": ("V", "V"),
            "time": ("s", "s")}  # fmt: skip


def first_guesses(recording: Recording, robot: Robot | None) -> list[Channel]:
    """Every column by its name, its own unit and its range."""
    joints = tuple(joint.name for joint in robot.joints) if robot else ()
    said = {name: meaning(first_of(name, recording.columns), joints) for name in recording.columns}
    units = recording.units
    said = {name: in_unit(m, known_unit(units.get(name, ""))) for name, m in said.items()}
    clock = time_column(recording, said)
    times = set(recording.clocks.values()) | same_as(clock, recording)
    said |= {name: replace(said[name], signal="time", joint=None) for name in times}
    of_letters, by_letters = lettered(said, robot)
    said |= not_symbols(said, joints) | of_letters
    numbers, ordered = _numbers({name: m for name, m in said.items() if name not in of_letters}, robot)
    numbers, ranked = _ranked(numbers, said, ordered, len(robot.joints) if robot else None)
    numbers |= {name: m.joint for name, m in of_letters.items() if isinstance(m.joint, int)}
    found = []
    for name, values in recording.columns.items():
        m = said[name]
        signal = "time" if name == clock else "other" if m.signal == "time" else m.signal
        if (signal == "voltage" and _supply(values)) or (signal == "switch" and not _switched(values)):
            signal = "other"
        unit = m.unit
        if signal == "unknown" and m.joint is not None and KINDS.get(unit or "") == "effort":
            signal = "torque"  # F3 [N]
        if signal == "torque" and unit in RATED:  # of a rated one, which has to be asked for as a current's
            signal = "current"
        kinds = _KIND.get(signal, ())
        if unit is not None and kinds and KINDS[unit] not in kinds:
            unit = None
        why = [f"{NAME} {name!r}"] if signal not in ("unknown",) and recording.header else []
        if unit:
            why.append(f"the unit {unit} that the file gives")
        placed = ((ordered, ORDER), (ranked, RANK), (by_letters, LETTERS))
        why += [reason for names, reason in placed if name in names]
        side, doubt = m.side, ""
        if side == "motor" and robot is not None and robot.transmission is None:
            side, doubt = "joint", f"{name}{MOTOR_SIDE}"
        found.append(
            Channel(
                column=name,
                values=np.asarray(values, float),
                rate=rate(recording, name, clock),
                signal=signal,
                joint=None if signal == "time" else numbers.get(name),
                side=side,
                unit=unit,
                wanted=m.wanted,
                clock=None if recording.clocks.get(name) == clock else recording.clocks.get(name),
                why=tuple(why),
                doubt=doubt if signal in ("position", "torque", "velocity") else "",
            )
        )
    found = [time_unit(c) if c.signal == "time" else c for c in found]
    seconds = {c.column: FACTORS[c.unit or "s"] for c in found if c.signal == "time"}
    return [replace(c, rate=c.rate / seconds.get(c.clock or clock or "", 1.0)) for c in found]


def _supply(values: np.ndarray) -> bool:
    """Whether a voltage hardly changes, as that of a battery, which drives nothing."""
    return bool(np.ptp(values) <= _STEADY * np.abs(np.mean(values)))


def _switched(values: np.ndarray) -> bool:
    """Whether there is nothing but off and on."""
    return bool(np.isin(values, (0, 1)).all())


def natural_unit(signal: str, kind: str) -> str:
    """The unit of a log's signal at a revolute or prismatic joint."""
    return _NATURAL[signal][0 if kind == "revolute" else 1]


def si(channel: Channel) -> np.ndarray:
    """The column (N,) in SI with sign and offset, the unit as guessed."""
    factor = FACTORS[channel.unit or "1"]
    return channel.sign * factor * channel.values + channel.offset * factor


def _numbers(said: dict[str, Meaning], robot: Robot | None) -> tuple[dict[str, int], set[str]]:
    """Joint (from 1) of every column that names one; numbers from 0 are shifted, words are ordered.

    Also the columns that only their order places: names without numbers, and numbers beside such names that
    would be taken twice (wrist_1 beside shoulder).
    """
    out: dict[str, int] = {}
    ordered: set[str] = set()
    groups: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    for name, m in said.items():
        stem = re.sub(r"\d+", "#", name) if isinstance(m.joint, int) else ""
        groups[(m.signal, m.side, stem if isinstance(m.joint, int) else "word")].append(name)
    merged = _merged(groups, said, robot)
    places = _places(merged, said)
    for (signal, _, stem), names in merged.items():
        whole = [j for j in (said[n].joint for n in names) if isinstance(j, int) and stem != "word"]
        if signal in _NO_JOINT and not whole:
            continue
        shift = 1 if whole and min(whole) == 0 and len(whole) == len(names) else 0
        if stem == "word":
            words = [n for n in names if said[n].joint not in (None, "")]
            known = all(_word(n, said) in places for n in words)
            out |= {n: places[_word(n, said)] if known else i for i, n in enumerate(words, start=1)}
            ordered |= set(words)
        else:
            out |= {n: j + shift for n, j in zip(names, whole, strict=True)}
        if len(names) == 1 and said[names[0]].joint is None and (robot is None or len(robot.joints) == 1):
            out[names[0]] = 1
    return out, ordered


def _ranked(
    numbers: dict[str, int], said: dict[str, Meaning], ordered: set[str], joints: int | None
) -> tuple[dict[str, int], set[str]]:
    """Numbers that cannot be those of joints from 1 on (a bus's 11, 12, 21) as places in their order.

    joints   of the robot, where it is known. Also the columns of which only that order tells the joint.
    """
    own = {n: j for n, j in numbers.items() if n not in ordered and said[n].signal not in _NO_JOINT}
    placed = {j for n, j in own.items() if said[n].signal == "position"} or set(own.values())
    place = {j: i for i, j in enumerate(sorted(placed), start=1)}
    counted = all(i == j for j, i in place.items()) if joints is None else max(placed, default=0) <= joints
    if counted or len(place) > (joints or len(place)):
        return numbers, set()
    others = {n: j for n, j in numbers.items() if n not in own}
    return others | {n: place[j] for n, j in own.items() if j in place}, set(own)


def _merged(
    groups: dict[tuple[str, str, str], list[str]], said: dict[str, Meaning], robot: Robot | None
) -> dict[tuple[str, str, str], list[str]]:
    """Names with numbers that stand among names without (wrist_1 after elbow) are names without, too."""
    out = dict(groups)
    for key, names in groups.items():
        words = [n for n in groups.get((key[0], key[1], "word"), []) if said[n].joint]
        own = len(words) < 2 or (robot is not None and len(names) >= len(robot.joints))
        if key[2] == "word" or own or key[0] in _NO_JOINT:
            continue
        if {_field(n) for n in names} & {_field(n) for n in words}:
            del out[key]
            both = set(out[(key[0], key[1], "word")]) | set(names)
            out[(key[0], key[1], "word")] = [n for n in said if n in both]
    return out


def _places(groups: dict[tuple[str, str, str], list[str]], said: dict[str, Meaning]) -> dict[str, int]:
    """Place of every joint without a number: the same for all its signals, by the order of the positions."""
    of = [key for key in groups if key[2] == "word" and key[0] not in _NO_JOINT]
    first = max(of, key=lambda key: (key[0] == "position", len(groups[key])), default=None)
    words = [_word(n, said) for n in groups[first] if said[n].joint not in (None, "")] if first else []
    return {word: place for place, word in enumerate(_naturally(dict.fromkeys(words)), start=1)}


def _naturally(words: Iterable[str]) -> list[str]:
    """In their order, but those that differ in numbers alone by these: wrist_2 before wrist_10."""
    stems: dict[str, list[str]] = defaultdict(list)
    for word in words:
        stems[re.sub(r"\d+", "#", word)].append(word)
    return [
        w
        for own in stems.values()
        for w in sorted(own, key=lambda w: [int(n) for n in re.findall(r"\d+", w)])
    ]


def _word(name: str, said: dict[str, Meaning]) -> str:
    """What stands for the joint in a name: fr_hip of FR_hip.q, wrist_1 of wrist_1.position_rad."""
    joint = said[name].joint
    before, _, after = name.rpartition(".")
    if isinstance(joint, int) and re.search(r"\d", before) and not re.search(r"\d", after):
        return before
    return joint if isinstance(joint, str) else name[: len(name) - len(_field(name))]


def _field(name: str) -> str:
    """What is last in a name: `position` of wrist_1.position."""
    return re.split(r"[^A-Za-z0-9]", name)[-1]


def of_signal(channels: Sequence[Channel], signal: str) -> dict[int, Channel]:
    """Channels of one signal by joint."""
    return {c.joint: c for c in channels if c.signal == signal and c.joint is not None}
