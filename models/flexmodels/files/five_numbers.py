"""Robot -> the five numbers per joint that simulators for learning take."""

import json
from pathlib import Path
from typing import Any

from flexmodels.atomic import replacing
from flexmodels.coordinate import joint_name
from flexmodels.joint import Joint
from flexmodels.robot import Robot

KEPT = frozenset({"motor_inertia", "coulomb", "viscous", "offset", "torque_delay"})
_UNITS = {
    "revolute": {"armature": "kg m2", "damping": "N m s/rad", "friction": "N m", "bias": "N m", "delay": "s"},
    "prismatic": {"armature": "kg", "damping": "N s/m", "friction": "N", "bias": "N", "delay": "s"},
}


def five_numbers(joint: Joint, delay: float = 0.0) -> dict[str, float]:
    """armature, damping, friction, bias (torque that the joint takes at rest), delay of the torque.

    delay   [s] of the command, which adds to a lag of the torque itself
    """

    def value(law: str, parameter: str) -> float:
        return float(joint.values.get(law, {}).get(parameter, 0.0))

    return {
        "armature": value("motor_inertia", "J_m"),
        "damping": value("viscous", "viscous"),
        "friction": value("coulomb", "coulomb"),
        "bias": value("offset", "offset"),
        "delay": delay + value("torque_delay", "delay"),
    }


def export_five_numbers(robot: Robot, path: str | Path) -> list[str]:
    """Write them as JSON, joint by joint; returns what they cannot say, a sentence each."""
    delay = robot.servo.delay if robot.servo else 0.0
    content: dict[str, Any] = {
        joint.name or joint_name(k): five_numbers(joint, delay) | {"units": _UNITS[joint.kind]}
        for k, joint in robot.numbered
    }
    with replacing(path) as file:
        file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    laws = {law for joint in robot.joints for law, values in joint.values.items() if any(values.values())}
    notes = []
    if robot.flexible:
        notes.append("five numbers per joint hold no flexible hinge: they are locked")
    if others := sorted(laws - KEPT - {"stiffness", "damping"}):
        notes.append(f"five numbers per joint have no place for {', '.join(others)}; they are left out")
    return notes
