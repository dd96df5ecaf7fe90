"""Messages of a ROS bag (MCAP, ROS 1 or ROS 2) as columns; needs the extra `ros`."""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pyident.logs.formats.recording import Recording
from pyident.logs.log import LogError

_STATE = "JointState"
_FEWEST = 3  # messages
_DEEP = 5  # levels of nested messages


def read_bag(path: Path) -> Recording:
    """The first JointState topic as `time` [s], `JOINT.position`, `.velocity`, `.effort`; other topics as
    `/topic/field` with the clock `/topic/time`; joints of messages of their own with a clock of their own.

    Raises LogError.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise LogError(f"{path}: bags need the extra: pip install 'flexident[ros]'") from None
    place = path if path.suffix in (".bag", ".mcap") or path.is_dir() else path.parent
    rows: dict[str, list[dict[str, float]]] = {}
    kinds: dict[str, str] = {}
    with AnyReader([place], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, stamp, raw in reader.messages():
            message: Any = reader.deserialize(raw, connection.msgtype)
            kinds[connection.topic] = connection.msgtype.rsplit("/", 1)[-1]
            values = _state(message) if kinds[connection.topic] == _STATE else dict(_fields(message, ""))
            rows.setdefault(connection.topic, []).append({"time": _stamp(message, stamp)} | values)
    states = [topic for topic in rows if kinds[topic] == _STATE]
    start = min((row["time"] for of in rows.values() for row in of), default=0.0)
    columns: dict[str, np.ndarray] = {}
    clocks: dict[str, str] = {}
    for topic, of in rows.items():
        ahead = "" if states and topic == states[0] else f"{topic}/"
        for clock, names, own in _sources(of, kinds[topic] == _STATE):
            columns[f"{ahead}{clock}"] = np.array([row["time"] for row in own]) - start
            columns |= {ahead + name: np.array([row[name] for row in own]) for name in names}
            if ahead or clock != "time":
                clocks |= {ahead + name: f"{ahead}{clock}" for name in names}
    if not columns:
        raise LogError(f"{path} has no topic with three messages of numbers, such as sensor_msgs/JointState")
    return Recording(columns, {}, clocks)


def _sources(
    rows: list[dict[str, float]], apart: bool
) -> Iterator[tuple[str, list[str], list[dict[str, float]]]]:
    """Messages of a topic by what they hold: the name of the clock, the other names, and the messages.

    apart   whether messages may be those of several groups of joints, such as an arm's and its gripper's:
            that with most joints has the clock `time`, another one `JOINT.time`, of its first joint
    """
    if len(rows) < _FEWEST:
        return
    names = dict.fromkeys(name for row in (rows if apart else rows[:1]) for name in row if name != "time")
    groups: dict[bytes, list[str]] = defaultdict(list)
    for name in names:
        groups[bytes(name in row for row in rows)].append(name)
    for i, (inside, own) in enumerate(sorted(groups.items(), key=lambda group: -len(group[1]))):
        if sum(inside) >= (_FEWEST if apart else len(rows)):
            clock = "time" if i == 0 else f"{own[0].rpartition('.')[0]}.time"
            yield clock, own, [row for row, here in zip(rows, inside, strict=True) if here]


def _state(message: Any) -> dict[str, float]:
    found = {}
    for i, joint in enumerate(message.name):
        for signal in ("position", "velocity", "effort"):
            if len(getattr(message, signal)) == len(message.name):
                found[f"{joint}.{signal}"] = float(getattr(message, signal)[i])
    return found


def _fields(value: Any, name: str, depth: int = 0) -> Iterator[tuple[str, float]]:
    """Every number in a message by its path."""
    if isinstance(value, bool | int | float | np.number):
        yield name.lstrip("."), float(value)
    elif isinstance(value, np.ndarray | list | tuple):
        if len(value) <= 64 and all(isinstance(v, int | float | np.number) for v in value):
            yield from ((f"{name.lstrip('.')}[{i + 1}]", float(v)) for i, v in enumerate(value))
    elif hasattr(value, "__dataclass_fields__") and depth < _DEEP:
        for part in value.__dataclass_fields__:
            if part not in ("header", "__msgtype__"):
                yield from _fields(getattr(value, part), f"{name}.{part}", depth + 1)


def _stamp(message: Any, received: int) -> float:
    header = getattr(message, "header", None)
    if header is None or (header.stamp.sec == 0 and header.stamp.nanosec == 0):
        return 1e-9 * received
    return header.stamp.sec + 1e-9 * header.stamp.nanosec
