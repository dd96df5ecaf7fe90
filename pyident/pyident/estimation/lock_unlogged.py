"""Flexible hinges that a log says nothing about are locked for the identification."""

from collections.abc import Sequence
from dataclasses import replace

from flexmodels.coordinate import deformation_of
from flexmodels.joint import Joint
from flexmodels.robot import Robot
from pyident.logs.log import Sampled


def locked(robot: Robot, logs: Sequence[Sampled]) -> tuple[Robot, list[str]]:
    """The robot with only those deformations that every log holds, and a sentence on each that was taken."""
    joints, notes = list(robot.joints), []
    for k, joint in robot.numbered:
        present = [i for i in joint.deformations if all(deformation_of(k, i) in log.names for log in logs)]
        if joint.flexible and 1 not in present:
            joints[k - 1] = _without(joint, flexible=False)
            notes.append(
                f"joint {k}: no link-side encoder (joint{k}.eps[1]), so its flexible hinge is locked; its "
                f"stiffness and damping cannot be told, nor its motor inertia from the inertia that it moves"
            )
        elif joint.flexible and len(present) < len(joint.deformations):
            joints[k - 1] = _without(joint, flexible=True)
            notes.append(
                f"joint {k}: its bending is not logged (joint{k}.eps[2], joint{k}.eps[3]), so it only twists "
                f"here; k[2], k[3], d[2] and d[3] cannot be told"
            )
    return replace(robot, joints=tuple(joints)), notes


def _without(joint: Joint, flexible: bool) -> Joint:
    values = {}
    for law, parameters in joint.values.items():
        if law in ("stiffness", "damping"):
            parameters = {name: v for name, v in parameters.items() if flexible and name.endswith("[1]")}
        if parameters:
            values[law] = parameters
    return replace(joint, flexible=flexible, bends=False, values=values)
