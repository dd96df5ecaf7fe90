"""Columns that a letter alone tells apart: X_Pos, Y_Pos and Z_Pos at three joints, A_Pos to F_Pos at six."""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import replace

from flexmodels.robot import Robot
from pyident.inspection.words import Meaning, meaning

_NO_JOINT = ("time", "other", "unknown")


def lettered(said: dict[str, Meaning], robot: Robot | None) -> tuple[dict[str, Meaning], set[str]]:
    """What such columns mean, with their joint (from 1), and those that only the letters' order places.

    said   of all columns, by their whole names
    A signal that has columns with joints of their own keeps these: x, y and z beside q1 to q3 are a tip's.
    """
    if robot is None:
        return {}, set()
    own = [joint.name.lower() for joint in robot.joints]
    sliders = all(joint.kind == "prismatic" for joint in robot.joints)
    found: dict[str, Meaning] = {}
    guessed: set[str] = set()
    for rest, names in _series(said, own):
        letters = sorted(names)
        shared = meaning(rest)
        if shared.signal == "unknown" and sliders and letters == ["x", "y", "z"]:
            shared = said[names["x"]]
        if shared.signal in _NO_JOINT:
            continue
        named = sorted(own) == letters
        order = own if named else letters
        found |= {names[letter]: replace(shared, joint=k) for k, letter in enumerate(order, start=1)}
        guessed |= set() if named else set(names.values())
    left = {_kind(m) for name, m in said.items() if name not in found and m.joint is not None}
    found = {name: m for name, m in found.items() if _kind(m) not in left}
    return found, guessed & set(found)


def _kind(m: Meaning) -> tuple[str, str]:
    return m.signal, m.side


def _series(names: Iterable[str], own: list[str]) -> Iterator[tuple[str, dict[str, str]]]:
    """What is left of names without a letter, and letter -> name: as many as joints, on end or theirs."""
    alike: dict[tuple[str, str, bool], dict[str, str]] = defaultdict(dict)
    for name in names:
        for i, letter in enumerate(name):
            if letter.isascii() and letter.isalpha():
                alike[name[:i], name[i + 1 :], letter.isupper()][letter.lower()] = name
    for (before, after, _), found in alike.items():
        on_end = "".join(sorted(found)) in "abcdefghijklmnopqrstuvwxyz"
        if len(found) == len(own) > 1 and (on_end or set(found) == set(own)):
            yield f"{before} {after}", found
