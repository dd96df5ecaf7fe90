"""From names and ranges to first guesses: which column is which signal of which joint, in which unit."""

import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.inspection.channel import LETTERS, ORDER, RANK, Channel
from pyident.inspection.letters import lettered
from pyident.inspection.words import Meaning, meaning
from pyident.logs.formats.recording import Recording
from pyident.logs.gaps import widest_gap
from pyident.logs.steps import usual_step
from pyident.logs.units import FACTORS, KINDS, known_unit

NAME = "its name"
MOTOR_SIDE = " is called that of a motor and the robot file has no gears: is it at the joint? (gear)"
_STEADY = 0.15  # of its mean: within it a voltage is a supply
_MOVES = 0.02  # of a clock's rows, at least, that are later than those before
_EVEN = 0.2  # of the median step: a clock's steps
_TIMES = {"s": (2e-5, 0.15), "ms": (0.15, 150.0), "us": (150.0, 1.5e5), "ns": (1.5e5, 1e9)}  # steps
_STAMPED = re.compile(r"header\W?stamp", re.IGNORECASE)
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
    said = {name: meaning(name, joints) for name in recording.columns}
    units = recording.units
    said = {name: replace(m, unit=known_unit(units.get(name, "")) or m.unit) for name, m in said.items()}
    clock = _time_column(recording, said)
    of_letters, by_letters = lettered(said, robot)
    said |= of_letters
    numbers, ordered = _numbers({name: m for name, m in said.items() if name not in of_letters}, robot)
    numbers, ranked = _ranked(numbers, said, ordered, len(robot.joints) if robot else None)
    numbers |= {name: m.joint for name, m in of_letters.items() if isinstance(m.joint, int)}
    times = set(recording.clocks.values()) | ({clock} if clock else set())
    found = []
    for name, values in recording.columns.items():
        m = said[name]
        signal = "time" if name == clock else "other" if m.signal == "time" or name in times else m.signal
        if (signal == "voltage" and _supply(values)) or (signal == "switch" and not _switched(values)):
            signal = "other"
        unit = m.unit
        if signal == "unknown" and m.joint is not None and KINDS.get(unit or "") == "effort":
            signal = "torque"  # F3 [N]
        if signal == "torque" and unit == "%":  # of a rated one, which has to be asked for as a current's
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
                rate=_rate(recording, name, clock),
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
    found = [_time_unit(c) if c.signal == "time" else c for c in found]
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


def grows_evenly(x: np.ndarray) -> bool:
    """Whether a column (N,) could be a clock."""
    steps = np.diff(x)
    if len(steps) < 3 or not np.isfinite(steps).all() or (steps <= 0).any():
        return False
    middle = float(np.median(steps))
    return bool(np.mean(np.abs(steps - middle) < max(_EVEN * middle, 1e-12)) > 0.8)


def no_clock(channel: Channel) -> str:
    """Why a column that is called a time is none; empty for other columns."""
    if meaning(channel.column).signal != "time":
        return ""
    x = np.asarray(channel.values, float)
    steps = np.diff(x)
    if not np.isfinite(x).all():
        return f"{channel.column} holds no number in row {int(np.argmin(np.isfinite(x))) + 1}"
    if (steps < 0).any():
        i = int(np.argmax(steps < 0))
        return f"{channel.column} goes back from {x[i]:.10g} to {x[i + 1]:.10g} at row {i + 2}"
    if np.mean(steps > 0) <= _MOVES:
        times = "one time" if np.ptp(x) == 0 else f"{len(np.unique(x))} times"
        return f"{channel.column} holds {times} in {len(x)} rows, as if digits were cut off"
    return f"{channel.column} stands still or jumps"


def _grows(x: np.ndarray) -> bool:
    """Whether it never falls: rows may come twice, and stamps may be coarse, but not for ever the same."""
    steps = np.diff(x)
    least = max(2, _MOVES * len(steps))
    return len(x) > 3 and bool(np.isfinite(x).all() and (steps >= 0).all() and (steps > 0).sum() > least)


def _time_column(recording: Recording, said: dict[str, Meaning]) -> str | None:
    own = set(recording.clocks.values())
    whole = {name: x for name, x in recording.columns.items() if len(x) == _longest(recording)}
    able = [name for name, x in whole.items() if grows_evenly(x)]
    named = [name for name in able if said[name].signal == "time"]
    if not named and recording.header:  # a bus answers when it can
        named = [name for name, x in whole.items() if said[name].signal == "time" and _grows(x)]
    named.sort(key=lambda name: _STAMPED.search(name) is None)  # when it was measured, not when it arrived
    if named:
        return next((name for name in named if name not in own or len(named) == 1), named[0])
    counts = [n for n in able if said[n].signal == "other"]
    rest = [n for n in able if n not in counts]
    return rest[0] if rest and (not recording.header or said[rest[0]].signal == "unknown") else None


def _longest(recording: Recording) -> int:
    return max(len(x) for x in recording.columns.values())


def _rate(recording: Recording, name: str, clock: str | None) -> float:
    own = recording.clocks.get(name, clock)
    if own is None:
        return float("nan")
    step = usual_step(np.asarray(recording.columns[own], float))
    return 1 / step if step > 0 else float("nan")


def gap(time: Channel) -> tuple[str, ...]:
    """A note where the time has a gap that an import would not fill."""
    steps = np.diff(np.asarray(time.values, float))
    if (i := widest_gap(steps, usual_step(time.values))) is None:
        return ()
    seconds = FACTORS[time.unit or "s"] * steps[i]
    return (f"{time.column} has a gap of {seconds:.3g} s at row {i + 2}: cut the log there",)


def _time_unit(channel: Channel) -> Channel:
    """s, ms, µs or ns by its steps; steps of one may be numbers of samples."""
    step = usual_step(channel.values)
    if channel.unit is not None:
        return replace(channel, sure=True)
    unit = next((unit for unit, (low, high) in _TIMES.items() if low <= step < high), None)
    counted = step == 1 and bool((channel.values == np.round(channel.values)).all())
    if unit is None or counted:
        ask = "it counts samples or milliseconds" if counted else f"its steps are {step:.3g}"
        return replace(channel, unit=unit, doubt=f"what is the unit of time? {ask}")
    seconds = step * FACTORS[unit]
    return replace(channel, unit=unit, sure=True, why=(*channel.why, f"steps of {1e3 * seconds:.4g} ms"))


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
    """What stands for the joint in a name: fr_hip of FR_hip.q, wrist_1. of wrist_1.position."""
    joint = said[name].joint
    return joint if isinstance(joint, str) else name[: len(name) - len(_field(name))]


def _field(name: str) -> str:
    """What is last in a name: `position` of wrist_1.position."""
    return re.split(r"[^A-Za-z0-9]", name)[-1]


def of_signal(channels: Sequence[Channel], signal: str) -> dict[int, Channel]:
    """Channels of one signal by joint."""
    return {c.joint: c for c in channels if c.signal == signal and c.joint is not None}
