"""What a column's name says: signal, joint, side and unit, in the words that loggers use."""

import re
from collections.abc import Container
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

from flexmodels.coordinate import divided, is_deformation
from pyident.logs.units import KINDS, known_unit

Signal = Literal["time", "position", "reference", "velocity", "acceleration", "torque", "feedforward",
                 "current", "voltage", "switch", "deformation", "other", "unknown"]  # fmt: skip
Side = Literal["joint", "motor", "link"]

_WORDS: dict[str, str] = {
    "time": "t time timestamp timestamps stamp zeit clock tsec secs elapsed",
    "position": "q pos position positions angle angles theta e qm phi encoder enc winkel lage state x "
    "istwert weg hub stroke travel qpos",
    "velocity": "dq qd vel velo velocity velocities speed omega qdot thetadot geschwindigkeit drehzahl v w "
    "rate dqm qvel spd geschw",
    "acceleration": "ddq qdd acc acceleration beschleunigung ddqm qddot qacc",
    "torque": "tau trq tq torque torques tauest effort efforts eff moment moments drehmoment "
    "force kraft load mot_torque m taum qfrc",
    "current": "i cur curr current currents iq strom amp amps",
    "voltage": "pwm duty volt voltage vir u spannung",
}
_BARE = {word: signal for signal, words in _WORDS.items() for word in words.split()}
_WANTED_WORDS = (
    "ref reference cmd command commands commanded des desired goal target set setpoint soll sollwert r "
    "action qg qref planned demand"
)
_WANTED = frozenset(_WANTED_WORDS.split())
_AHEAD = set(["ff", "feedforward", "feed_forward", "tauff", "vorsteuerung"])
_MOTOR = set(["motor", "mot", "drive", "antrieb", "rotor"])
_LINK = set(["link", "se", "secondary", "output", "abtrieb", "load_side"])
_OTHER_WORDS = (
    "temp temperature temperatures status error err flag frame episode index task done reward volts input "
    "mode enable enabled seq count following diff difference deviation et runtime machine safety "
    "schleppfehler stiffness damping kp kd ki ext external tip tcp ee eef effector endeffector cartesian "
    "cart pose wrench imu rpy quat quaternion scaling override fraction factor"
)
_OTHER = frozenset(_OTHER_WORDS.split())
_MEASURED = frozenset(["act", "actual", "meas", "measured", "msr", "ist", "present"])
_OF_THE_MODEL = frozenset(["bias", "passive", "constraint", "smooth", "inverse", "gravcomp"])  # MuJoCo's qfrc
_SWITCH = frozenset(["enable", "enabled"])
_SWITCHED = frozenset(["torque", "motor", "servo", "drive"])
_PLAIN = frozenset(  # of no joint's name
    [*_MEASURED, "est", "hat", "filtered", "raw", "dot", "ddot", "d", "actuator"]
)
_AXES = frozenset(["axis", "axes", "joint", "joints", "achse", "achsen"])
_MOTIONS = frozenset(["angle", "length", "speed"])
_MEASURES = {"angle": "position", "length": "position", "speed": "velocity", "effort": "torque"}
_CAPITALS = {"A": {"current", "voltage"}, "V": {"current", "voltage"}, "N": {"torque"}}
_ADDRESS = re.compile(r"\b0x[0-9A-Fa-f]{2,8}\b")  # of an object on a bus: 0x6064 is no joint
_TYPE = re.compile(r"(?<![A-Za-z0-9])[A-Za-z][1-9]\d{2,}(?![A-Za-z0-9])")  # of a robot, as R800: no r
_AGAIN = re.compile(r" \(\d+\)$")  # the mark of a name that comes twice
_PLACES = frozenset([*_AXES, *_MOTOR, *_LINK, "j", "gelenk"])
_SPLIT = re.compile(r"[^A-Za-z0-9°µ]+")
_GERMAN = re.compile(
    r"(ist|soll|(?:motor|antrieb|abtrieb|rotor)(?:s(?!trom))?)(?=[a-z]{3})"
)  # Antriebsmoment
_GERMAN_VALUE = re.compile(r"(.{3,}?)(ist|soll)wert")  # Drehmomentistwert
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Za-z])(?=\d)|(?<=\d)(?=[A-Za-z])|(?<=Q)(?=[A-Z][a-z])")


@dataclass(frozen=True)
class Meaning:
    """What a name says. joint: a number, a word, or None; unit: ours, or None.

    wanted   whether it is of what was asked for, not of what was measured
    """

    signal: Signal
    joint: int | str | None
    side: Side
    unit: str | None
    wanted: bool = False


def meaning(name: str, joints: tuple[str, ...] = ()) -> Meaning:
    """Of a column's name, also of our own; joints: names of the robot's joints, which may be part of it."""
    if is_deformation(name):
        return Meaning("deformation", divided(name)[0], "link", "rad")
    joint, rest = _joint(_without_type(_ADDRESS.sub(" ", name)), joints)
    words = [word.lower() for part in _SPLIT.split(rest) for word in _CAMEL.split(part) if word]
    words = [part for word in words for part in _parts(word)]
    numbers = [int(word) for word in words if word.isdigit()]
    words = [word for word in words if not word.isdigit()]
    unit = _last_unit(rest) or next((unit for size in (2, 1) if (unit := _unit(words[-size:]))), None)
    if unit and len(words) > 1:
        words = words[:-1]
    unit = unit or _inner_unit(rest)
    words = _of_the_load(_of_now(words), KINDS.get(unit or ""))
    words = [a for a, b in pairwise([*words, ""]) if not (a == "link" and b in _AXES)]  # arm_link_joint
    side: Side = "motor" if _MOTOR & set(words) else "link" if _LINK & set(words) else "joint"
    if joint is None and numbers:
        joint = numbers[-1]
    left = [w for w in words if w not in _BARE and w not in _WANTED and w not in _MOTOR | _LINK | _SWITCH]
    if joint is None and len(left) and "observation" not in left:
        joint = "_".join(w for w in left if w not in _PLAIN or (w == "d" and not _desired(words)))
    signal = _signal(words, KINDS.get(unit or ""))
    if signal == "unknown" and isinstance(joint, int) and all(w in _PLACES or known_unit(w) for w in words):
        signal = _MEASURES.get(KINDS.get(unit or "", ""), signal)  # j1_deg
    return Meaning(signal, joint if joint != "" else None, side, unit, _wanted(words))  # pyright: ignore


def in_unit(said: Meaning, unit: str | None) -> Meaning:
    """With the unit that a file gives, if any: it tells what is measured of a motor (`A1.Motor [deg]`)."""
    kind = KINDS.get(unit or "", "")
    moves = said.signal == "unknown" and said.side != "joint" and kind in _MOTIONS
    return replace(said, unit=unit or said.unit, signal=_MEASURES[kind] if moves else said.signal)  # pyright: ignore


def is_symbol(letter: str) -> bool:
    """Whether a single letter stands for a signal where nothing else says so."""
    return letter in _BARE or letter in _WANTED


def first_of(name: str, names: Container[str]) -> str:
    """A name that was marked as it comes twice (`q1 (2)`), without the mark."""
    bare = _AGAIN.sub("", name)
    return bare if bare in names else name


def _without_type(name: str) -> str:
    """Without the type of a robot, R800, where another number is left."""
    bare = _TYPE.sub(" ", name)
    return bare if re.search(r"\d", bare) else name


def _of_the_load(words: list[str], kind: str | None) -> list[str]:
    """A load is a torque, but in the name of a position or a speed it is the side that is measured.

    The present load of a servo is its duty (Dynamixel, Feetech: parts of the largest).
    """
    if {"present", "load"} <= set(words):
        return ["duty" if word == "load" else word for word in words]
    others = {_BARE.get(word) for word in words if len(word) > 1}
    moves = kind in _MOTIONS or bool(others & {"position", "velocity", "acceleration"})
    return ["link" if moves and word == "load" else word for word in words]


def _of_now(words: list[str]) -> list[str]:
    """What stands in front of what moves says when: current_position is no current."""
    moving = {word for word, signal in _BARE.items() if signal in ("position", "velocity", "torque")}
    return [
        "actual" if word == "current" and after in moving - {"e", "m", "v", "w", "x"} else word
        for word, after in pairwise([*words, ""])
    ]


def _parts(word: str) -> list[str]:
    """A word, in two where it is put together of what it is of and what it is."""
    begin = _GERMAN.match(word)
    if begin and word not in _BARE and word not in _WANTED and word[begin.end() :] in _BARE:
        return [begin.group().removesuffix("s"), word[begin.end() :]]
    value = _GERMAN_VALUE.fullmatch(word)
    if value and value[1] in _BARE:
        return [value[1], value[2]]
    return [word]


def _wanted(words: list[str]) -> bool:
    """Whether it was asked for; the d of q_d says so, a bare d does not."""
    applied = "qfrc" in words and "applied" in words  # MuJoCo: what was asked for beside the actuators
    return bool(set(words) & _WANTED) or _desired(words) or applied


def _desired(words: list[str]) -> bool:
    """Whether a d behind a signal says so: of q_d, not of finger_d, which is the right one."""
    return any(word == "d" and before in _BARE for before, word in pairwise(words))


def _signal(words: list[str], kind: str | None) -> Signal:
    """kind: what its unit measures, where the name has one."""
    if set(words) & _SWITCH and set(words) & _SWITCHED:
        return "switch"
    if set(words) & _OTHER or words[-1:] == ["id"] or ("qfrc" in words and set(words) & _OF_THE_MODEL):
        return "other"
    found, wanted = _found(words, kind), _wanted(words)
    if set(words) & _AHEAD:
        return "feedforward" if not found or "torque" in found else "other"
    if "torque" in found and wanted:
        return "torque"
    if words and _BARE.get(words[-1]) == "time":
        return "time"
    plain = [signal for signal in found if signal != "time"] or found
    if wanted:
        return "reference" if not plain or plain[-1] == "position" else "other"
    order = ("acceleration", "velocity", "torque", "current", "voltage", "position", "time")
    best = next((signal for signal in order if signal in plain), None)
    if best is None and {"ist", *_AXES} & set(words) and _MEASURED & set(words):
        return "position"
    return best or "unknown"  # pyright: ignore[reportReturnType]


def _found(words: list[str], kind: str | None) -> list[str]:
    """The signals that words name; a single letter counts where no longer word does (the m of m1_pos).

    What a unit measures says more than a letter.
    """
    named = {word: _BARE[word] for word in words if word in _BARE}
    if "q" in named:  # the m of m1_q is no moment
        named.pop("m", None)
    long = {word: signal for word, signal in named.items() if len(word) > 1}
    chosen = list((long if set(long.values()) - {"time"} else named).values())
    if not chosen and kind in _MOTIONS and set(words) & (_MOTOR | _LINK):
        chosen = [_MEASURES[kind]]
    if chosen and not long and _MEASURES.get(kind or "", chosen[0]) not in chosen:
        chosen = [_MEASURES[str(kind)]]
    derived = "acceleration" if "ddot" in words else "velocity" if "dot" in words else None
    return [derived if derived and signal == "position" else signal for signal in chosen]


def _last_unit(name: str) -> str | None:
    """The unit that a name ends with, where its capitals matter (cur_mA, current_A)."""
    *words, last = _SPLIT.split(name)
    if last in _CAPITALS:  # an axis may be called so, but that of a current
        said = {_BARE.get(word.lower()) for word in words if len(word) > 1}
        return known_unit(last) if said & _CAPITALS[last] else None
    return known_unit(last) if len(last) > 1 and last not in ("min", "rev") else None


def _inner_unit(name: str) -> str | None:
    """The unit that follows a signal's word (current_mA_joint1)."""
    after = (b for a, b in pairwise(_SPLIT.split(name)) if len(a) > 1 and a.lower() in _BARE)
    units = (known_unit(word) for word in after if len(word) > 1 and word not in ("in", "min", "rev"))
    return next((unit for unit in units if unit), None)


def _unit(words: list[str]) -> str | None:
    text = "_".join(words)
    for tried in (text, text.replace("_", "/"), text.replace("_", ".")):
        if len(tried) > 1 and (unit := known_unit(tried)) and tried not in ("min", "rev"):
            return unit
    return {"rads": "rad/s", "degs": "deg/s"}.get(text)


def _joint(name: str, joints: tuple[str, ...]) -> tuple[int | None, str]:
    """The number of the robot's joint that the name holds, and the name without it."""
    low = name.lower()
    for k, joint in sorted(enumerate(joints, start=1), key=lambda pair: -len(pair[1])):
        if len(joint) > 1 and joint.lower() in low:
            at = low.index(joint.lower())
            after = low[at + len(joint) : at + len(joint) + 1]
            if not after.isdigit():
                return k, name[:at] + " " + name[at + len(joint) :]
    return None, name
