"""Messages of joints as a table without header, as `ros2 topic echo --csv /joint_states` writes them.

sensor_msgs/JointState in the order of its definition: seconds, nanoseconds, frame, the names of n joints,
then n positions, n velocities and n efforts; what a driver does not fill is missing.
"""

import pandas as pd

_STAMP = ("stamp.sec", "stamp.nanosec", "frame_id")
_FIELDS = {1: ("position",), 3: ("position", "velocity", "effort")}  # two may be either of the last


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
