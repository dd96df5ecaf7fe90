"""Columns that a letter alone tells apart: X_Pos, Y_Pos and Z_Pos at three joints, A_Pos to F_Pos at six.

Machine tools call their sliders X, Y, Z and their hinges A, B, C (DIN 66217).
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace

from flexmodels.robot import Robot
from pyident.inspection.words import Meaning, is_symbol, meaning
from pyident.logs.units import KINDS, known_unit

_NO_JOINT = ("time", "other", "unknown")
_SLIDERS, _HINGES = "xyz", "abc"
_CARTESIAN = frozenset(["x", "y", "z", "w", "rx", "ry", "rz"])
_ALONE = re.compile(r"(?<![A-Za-z0-9])([A-Za-z]|[Rr][XYZxyz])(\d?)(?![A-Za-z0-9])")
_UNIT = re.compile(r"^(.*?)[ _.]([^ _.]+)$")


def lettered(said: dict[str, Meaning], robot: Robot | None) -> tuple[dict[str, Meaning], set[str]]:
    """What such columns mean, with their joint (from 1), and those that only the letters' order places.

    said   of all columns, by their whole names
    A signal that has columns with joints of their own keeps these: x, y and z beside q1 to q3 are a tip's.
    """
    if robot is None or len(robot.joints) < 2:
        return {}, set()
    own = [joint.name.lower() for joint in robot.joints]
    kinds = [joint.kind for joint in robot.joints]
    sliders = all(kind == "prismatic" for kind in kinds)
    found: dict[str, Meaning] = {}
    guessed: set[str] = set()
    for names, rests in _series(said, len(own)):
        order = own if set(names) == set(own) else _order(set(names), kinds)
        if order is None:
            continue
        meanings = {letter: meaning(rest) for letter, rest in rests.items()}
        meanings = {a: replace(m, unit=m.unit or said[names[a]].unit) for a, m in meanings.items()}
        if sliders and order == ["x", "y", "z"] and {m.signal for m in meanings.values()} == {"unknown"}:
            meanings = {letter: said[names["x"]] for letter in order}
        if all(_measures(meanings[letter], kind) for letter, kind in zip(order, kinds, strict=True)):
            meanings = {letter: replace(m, signal="position") for letter, m in meanings.items()}
        signals = {m.signal for m in meanings.values()}
        if len(signals) > 1 or signals & set(_NO_JOINT):
            continue
        found |= {
            names[letter]: replace(meanings[letter], joint=k) for k, letter in enumerate(order, start=1)
        }
        guessed |= set() if order is own else set(names.values())
    left = {_kind(m) for name, m in said.items() if name not in found and m.joint is not None}
    found = {name: m for name, m in found.items() if _kind(m) not in left}
    return found, guessed & set(found)


def not_symbols(said: dict[str, Meaning], joints: tuple[str, ...]) -> dict[str, Meaning]:
    """What columns mean of which a letter tells the axis, not the signal: left_s0, left_e0 and left_w0.

    said     of all columns, by their whole names
    joints   the names of the robot's joints: what they are part of needs no letters
    Three letters or more in one place tell it, where some of them stand for no signal. X, y and z are those
    of a point, which is no joint's.
    """
    alike: dict[tuple[str, str], dict[str, str]] = defaultdict(dict)
    for name in said:
        if any(joint.lower() in name.lower() for joint in joints if len(joint) > 1):
            continue
        for found in _ALONE.finditer(name):
            before, after = name[: found.start()], name[found.end() :]
            if re.search("[A-Za-z]", before + after) and not re.search(r"\d", before + after):
                alike[before, after][found.group().lower()] = name
    out: dict[str, Meaning] = {}
    for (before, after), names in alike.items():
        letters = {axis.rstrip("0123456789") for axis in names}
        if letters <= _CARTESIAN and ({"x", "y"} <= letters or {"rx", "ry"} <= letters):
            out |= {name: replace(said[name], signal="other", joint=None) for name in names.values()}
        elif _axes(letters):
            m, word = meaning(f"{before} {after}"), re.sub("[^A-Za-z]", "", before).lower()
            out |= {name: replace(m, joint=f"{word}_{axis}") for axis, name in names.items()}
    return out


def _axes(letters: set[str]) -> bool:
    """Whether letters are those of axes: q is that of an angle, and among some others t that of time."""
    strange = sum(not is_symbol(letter) for letter in letters)
    return len(letters) > 2 and strange > 0 and "q" not in letters and (
        "t" not in letters or 2 * strange >= len(letters)
    )  # fmt: skip


def _measures(m: Meaning, kind: str) -> bool:
    """Whether a column of which no word says what it is has the unit of a joint's position."""
    unit = "length" if kind == "prismatic" else "angle"
    return m.signal == "unknown" and KINDS.get(m.unit or "") == unit


def _kind(m: Meaning) -> tuple[str, str]:
    return m.signal, m.side


def _order(letters: set[str], kinds: Sequence[str]) -> list[str] | None:
    """Letters by joint: on end in the alphabet, or those of a machine tool by the kind of its joints."""
    alphabet = sorted(letters)
    if "".join(alphabet) in "abcdefghijklmnopqrstuvwxyz":
        return alphabet
    straight, turning = ([a for a in axes if a in letters] for axes in (_SLIDERS, _HINGES))
    if len(straight) != kinds.count("prismatic") or len(straight) + len(turning) != len(kinds):
        return None
    left = {"prismatic": iter(straight), "revolute": iter(turning)}
    return [next(left[kind]) for kind in kinds]


def _series(said: dict[str, Meaning], joints: int) -> Iterator[tuple[dict[str, str], dict[str, str]]]:
    """Letter -> name, and -> the name without it: as many as joints, alike but for letter and unit."""
    alike: dict[tuple[str, str, bool], dict[str, tuple[str, str]]] = defaultdict(dict)
    for name in said:
        for i, letter in enumerate(name):
            if letter.isascii() and letter.isalpha():
                before, after = name[:i], name[i + 1 :]
                key = before, _without_unit(after), letter.isupper()
                alike[key][letter.lower()] = name, f"{before} {after}"
    for found in alike.values():
        if len(found) == joints:
            yield {a: name for a, (name, _) in found.items()}, {a: rest for a, (_, rest) in found.items()}


def _without_unit(text: str) -> str:
    parts = _UNIT.match(text)
    return parts[1] if parts and known_unit(parts[2]) else text
