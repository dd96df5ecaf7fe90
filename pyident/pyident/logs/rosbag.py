"""JointState messages of a ROS bag (MCAP, ROS 1 or ROS 2); needs the extra `ros`."""

from pathlib import Path
from typing import Any

import numpy as np

from pyident.logs.log import LogError


def read_bag(path: Path) -> dict[str, np.ndarray]:
    """Columns `time` [s], `JOINT.position`, `JOINT.velocity`, `JOINT.effort` of the first JointState topic.

    Raises LogError.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise LogError(f"{path}: bags need the extra: pip install 'flexident[ros]'") from None
    place = path if path.suffix in (".bag", ".mcap") else path.parent
    with AnyReader([place], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        topics = [c for c in reader.connections if c.msgtype == "sensor_msgs/msg/JointState"]
        if not topics:
            raise LogError(f"{path} has no topic of type sensor_msgs/JointState")
        messages: list[Any] = [
            reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(topics[:1])
        ]
    columns = {"time": np.array([_seconds(m) for m in messages])}
    columns["time"] -= columns["time"][0]
    for i, joint in enumerate(messages[0].name):
        for signal in ("position", "velocity", "effort"):
            if len(getattr(messages[0], signal)) == len(messages[0].name):
                columns[f"{joint}.{signal}"] = np.array([getattr(m, signal)[i] for m in messages])
    return columns


def _seconds(message: Any) -> float:
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
