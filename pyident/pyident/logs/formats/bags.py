"""Messages of a ROS bag (MCAP, ROS 1 or ROS 2) as columns; needs the extra `ros`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pyident.logs.formats.recording import Recording
from pyident.logs.log import LogError

_STATE = "JointState"
_DEEP = 5  # levels of nested messages


def read_bag(path: Path) -> Recording:
    """The first JointState topic as `time` [s], `JOINT.position`, `.velocity`, `.effort`; other topics as
    `/topic/field` with the clock `/topic/time`. Raises LogError.
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
        names = [name for name in of[0] if all(name in row for row in of)]
        if len(names) < 2 or len(of) < 3:
            continue
        for name in names:
            columns[ahead + name] = np.array([row[name] for row in of])
            if ahead and name != "time":
                clocks[ahead + name] = f"{ahead}time"
        columns[f"{ahead}time"] -= start
    if not columns:
        raise LogError(f"{path} has no topic with numbers, such as sensor_msgs/JointState")
    return Recording(columns, {}, clocks)


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
