"""Messages of joints as a table without header, as `ros2 topic echo --csv /joint_states` writes them.

sensor_msgs/JointState in the order of its definition: seconds, nanoseconds, frame, the names of n joints,
then n positions, n velocities and n efforts; what a driver does not fill is missing.
"""

import re
from collections.abc import Mapping

import numpy as np
import pandas as pd

from pyident.logs.log import LogError

_STAMP = ("stamp.sec", "stamp.nanosec", "frame_id")
_NAME = re.compile(r"(.*[^a-z])?name([\W_]?\d+\W?)")  # field.name0, name[0], name_0
_SIGNALS = ("position", "velocity", "effort")
_FIELDS = {1: ("position",), 3: _SIGNALS}  # two may be either of the last


def message_names(frame: pd.DataFrame) -> tuple[str, ...] | None:
    """Names of all columns, those without a value included; None for a table of anything else.

    frame   its columns numbered from 0, those without a value left out
    """
    total = 1 + max(int(label) for label in frame.columns)
    if not {0, 1} <= set(frame.columns):
        return None
    joints: list[str] = []
    for label in range(len(_STAMP), total):
        name = _text(frame, label)
        if name is None:
            break
        joints.append(name)
    left, n = total - len(_STAMP) - len(joints), len(joints)
    if n == 0 or len(set(joints)) < n or left % n or left // n not in _FIELDS:
        return None
    fields = _FIELDS[left // n]
    return (*_STAMP, *(f"{j}.name" for j in joints), *(f"{j}.{field}" for field in fields for j in joints))


def _text(frame: pd.DataFrame, label: int) -> str | None:
    """The one word that a column holds in every row."""
    if label not in frame.columns or pd.api.types.is_numeric_dtype(frame[label]):
        return None
    words = set(frame[label].astype(str))
    return words.pop() if len(words) == 1 else None


def with_joint_names(
    columns: Mapping[str, np.ndarray], texts: Mapping[str, pd.Series]
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Places of messages (field.position0) under the joint that the row names for them (field.name0).

    columns, texts   the columns of numbers (N,) and of words
    Also the columns of words that name no joint. Raises LogError where rows name different joints.
    """
    places = {name: found for name in texts if (found := _NAME.fullmatch(name)) is not None}
    fields = {word: [f"{found[1] or ''}{word}{found[2]}" for found in places.values()] for word in _SIGNALS}
    fields = {word: names for word, names in fields.items() if all(name in columns for name in names)}
    if not places or not fields:
        return dict(columns), list(texts)
    said = np.array([texts[name].astype(str).str.strip() for name in places])
    joints = list(dict.fromkeys(said[:, 0]))
    order = np.argsort(said, axis=0)
    if (np.take_along_axis(said, order, 0) != np.sort(joints)[:, None]).any() or len(joints) < len(places):
        raise LogError(
            f"the joints that {next(iter(places))} and its neighbours name change from row to row; keep "
            "the rows of one group of joints"
        )
    out = {name: x for name, x in columns.items() if not any(name in names for names in fields.values())}
    place = {joint: i for i, joint in enumerate(np.sort(joints))}
    for word, names in fields.items():
        values = np.take_along_axis(np.array([columns[name] for name in names]), order, 0)
        out |= {f"{joint}.{word}": values[place[joint]] for joint in joints}
    return out, [name for name in texts if name not in places]
