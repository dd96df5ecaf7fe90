"""Flexible hinges that a log says nothing about are locked for the identification."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from flexmodels.coordinate import deformation_of
from flexmodels.joint import Joint
from flexmodels.robot import Robot
from pyident.logs.log import Sampled


def locked(robot: Robot, logs: Sequence[Sampled]) -> tuple[Robot, list[str]]:
    """The robot with only those deformations that every log holds, and a sentence on each that was taken, or
    is logged in vain.
    """
    joints, notes = list(robot.joints), []
    for k, joint in robot.numbered:
        present = [i for i in joint.deformations if all(deformation_of(k, i) in log.names for log in logs)]
        if joint.flexible and 1 not in present:
            joints[k - 1] = _without(joint, flexible=False)
            notes.append(locked_note(k))
        elif not joint.flexible and all(deformation_of(k, 1) in log.names for log in logs):
            notes.append(
                f"joint {k}: {deformation_of(k, 1)} is logged and not used, as the robot file has a rigid "
                "joint there; give it a stiffness, as k = [1e4] under its [[joint]], and `identify` finds "
                "the hinge"
            )
        elif joint.flexible and len(present) < len(joint.deformations):
            joints[k - 1] = _without(joint, flexible=True)
            notes.append(
                f"joint {k}: its bending is not logged (joint{k}.eps[2], joint{k}.eps[3]), so it only twists "
                f"here; k[2], k[3], d[2] and d[3] cannot be told"
            )
    return replace(robot, joints=tuple(joints)), notes


def locked_in(whole: Robot, robot: Robot) -> list[int]:
    """Joints, from 1, whose hinge bends in the whole robot and is locked in that of some logs."""
    pairs = zip(whole.numbered, robot.joints, strict=True)
    return [k for (k, joint), own in pairs if joint.flexible and not own.flexible]


def without_loop(whole: Robot, robot: Robot) -> tuple[Robot, list[str]]:
    """The robot of some logs without its controller where its hinges that bend are all locked, and why.

    With rigid drives the loop would move, and answer noise, as another machine does. Where some bend in the
    model, the loop stays: equations of hinges are better held against simulations.
    """
    stiff = [str(k) for k in locked_in(whole, robot)]
    if robot.controller is None or robot.flexible or not stiff:
        return robot, []
    listed = f"joint {stiff[0]}" if len(stiff) == 1 else f"joints {', '.join(stiff)}"
    said = (
        f"the hinge of {listed} is locked, and with rigid drives the loop would be another machine's: the "
        "[controller] is not used, and the motion is taken as it was measured"
    )
    return replace(robot, controller=None), [said]


def locked_note(joint: int) -> str:
    """What is said of a joint, from 1, whose hinge is locked."""
    return (
        f"joint {joint}: no link-side encoder (joint{joint}.eps[1]), so its flexible hinge is locked; its "
        f"stiffness and damping cannot be told, nor its motor inertia from the inertia that it moves"
    )


def unlocked(robot: Robot, hinges: Mapping[int, Mapping[str, float]]) -> Robot:
    """The robot with hinges that twist, by joint with their `k[1]` and `d[1]`."""
    joints = list(robot.joints)
    for k, values in hinges.items():
        own = {
            **joints[k - 1].values,
            "stiffness": {"k[1]": values["k[1]"]},
            "damping": {"d[1]": values["d[1]"]},
        }
        joints[k - 1] = replace(joints[k - 1], flexible=True, bends=False, values=own)
    return replace(robot, joints=tuple(joints))


def _without(joint: Joint, flexible: bool) -> Joint:
    values = {}
    for law, parameters in joint.values.items():
        if law in ("stiffness", "damping"):
            parameters = {name: v for name, v in parameters.items() if flexible and name.endswith("[1]")}
        if parameters:
            values[law] = parameters
    return replace(joint, flexible=flexible, bends=False, values=values)
