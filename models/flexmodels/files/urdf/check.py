"""That a URDF is a tree of distinct names and finite numbers, before anything is built of it."""

from collections import Counter
from collections.abc import Iterator
from math import isfinite
from typing import Any

from flexmodels.files.toml_table import LARGEST_NUMBER, line_of_text
from flexmodels.robot import RobotError

MOST_JOINTS = 100  # that move; the equations of more take hours to derive
_NAMED = 4  # links in a sentence
_NOT_NEGATIVE = ("ixx", "iyy", "izz", "value", "velocity", "effort", "damping", "friction")
_NUMBERS = (*_NOT_NEGATIVE, "xyz", "rpy", "ixy", "ixz", "iyz", "lower", "upper")


def check_urdf(root: Any) -> None:
    """root: the lxml element `robot`. Raises RobotError."""
    if root.tag != "robot":
        raise RobotError(f"its root is <{root.tag}>, not <robot>")
    _check_expanded(root)
    _check_names(root)
    _check_tree(root)
    _check_mimics(root)
    for element in root.iter():
        if isinstance(element.tag, str):
            _check_numbers(element)
    for joint in root.iterfind("joint"):
        limit = joint.find("limit")
        if limit is not None and float(limit.get("lower", 0)) > float(limit.get("upper", 0)):
            raise RobotError(f"joint {joint.get('name')} has a lower limit above its upper one; swap them")


def require_few(joints: int) -> None:
    """Raises RobotError for more joints than can be computed with."""
    if joints > MOST_JOINTS:
        raise RobotError(f"{joints} joints move, {MOST_JOINTS} are the most; make those fixed that can be")


def _check_expanded(root: Any) -> None:
    own = [element for element in root.iter() if isinstance(element.tag, str)]
    if any("/xacro}" in element.tag or any("${" in value for value in element.values()) for element in own):
        raise RobotError("it is xacro, not yet URDF; expand it: xacro FILE > robot.urdf")


def _check_mimics(root: Any) -> None:
    joints = {joint.get("name") for joint in root.iterfind("joint")}
    for joint in root.iterfind("joint"):
        for mimic in joint.iterfind("mimic"):
            name, other = joint.get("name"), mimic.get("joint")
            if other == name:
                raise RobotError(f"joint {name} mimics itself; leave <mimic> out")
            if other not in joints:
                raise RobotError(
                    f"joint {name} mimics {other}, which is not there; add it or leave <mimic> out"
                )


def _check_names(root: Any) -> None:
    line_of_text(root.get("name", "robot"), "robot.name")
    for kind in ("link", "joint"):
        names = [
            line_of_text(element.get("name"), f"the name of a {kind}") for element in root.iterfind(kind)
        ]
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise RobotError(f"there are two {kind}s {twice[0]}; give each a name of its own")


def _check_tree(root: Any) -> None:
    links = {str(link.get("name")) for link in root.iterfind("link")}
    parents: dict[str, str] = {}
    for joint in root.iterfind("joint"):
        name = joint.get("name")
        ends = [end.get("link") if end is not None else None for end in map(joint.find, ("parent", "child"))]
        for end in ends:
            if end not in links:
                raise RobotError(f"joint {name} joins link {end}, which is not there; add it")
        parent, child = ends
        if child in parents:
            raise RobotError(f"link {child} has two parents; a robot is a tree, so leave one joint out")
        parents[child] = parent  # pyright: ignore[reportArgumentType]
    if not links:
        raise RobotError(
            "it has no links; where xacro made it, that file only defined macros: run xacro on the one that "
            "uses them"
        )
    for link in sorted(links):
        for ancestor in _ancestors(link, parents):
            if ancestor == link:
                raise RobotError(f"link {link} hangs on itself through its joints; break the cycle")
    roots = sorted(links - parents.keys())
    if len(roots) > 1:
        names = ", ".join(roots[:_NAMED]) + (", ..." if len(roots) > _NAMED else "")
        raise RobotError(
            f"{len(roots)} links have no parent ({names}); only the base may have none: join the others to "
            "it, or leave them out"
        )


def _ancestors(link: str, parents: dict[str, str]) -> Iterator[str]:
    for _ in range(len(parents)):
        if link not in parents:
            return
        link = parents[link]
        yield link


def _check_numbers(element: Any) -> None:
    for key in _NUMBERS:
        for word in (element.get(key) or "").split():
            owner = next((above.get("name") for above in element.iterancestors() if above.get("name")), None)
            place = f"{key} of <{element.tag}> in {owner}"
            try:
                number = float(word)
            except ValueError:
                raise RobotError(f"{place} is {word[:40]!r}, not a number") from None
            if not isfinite(number) or abs(number) > LARGEST_NUMBER:
                raise RobotError(f"{place} is {word[:40]}, not a finite number up to {LARGEST_NUMBER:g}")
            if key in _NOT_NEGATIVE and number < 0:
                raise RobotError(f"{place} is {word[:40]}; it cannot be negative")
