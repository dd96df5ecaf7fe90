"""What a robot file may say wrongly of a machine's geometry and sensors, and the column of each such error.

With the file's description Φ p misses the torques by δ ∂(Φ p)/∂θ, to first order in the error δ of what the
file states as θ: a joint's origin or axis, where an encoder reads zero, the direction of gravity, the gain of
a torque. The derivatives are differences of Φ p itself over the corrected robot, so that there is one
geometry only; in a step of 1e-6 curvature and rounding are some millionths of a column.

An encoder's zero is a turn of everything behind the joint about its axis in the zero pose.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from flexmodels.joint import Joint
from flexmodels.robot import Robot, RobotError
from pyident.conditioning.motion import Motion
from pyident.regression.loads.forces import as_they_are, link_forces_along
from pyident.regression.loads.swinging_drive import NO_SPRINGS, Springs
from pyident.regression.outside_file import ANSWER, BEND, GAIN, LAG, RATIO, Outside

DRIVE = "drive_compliance"
DELAY = "servo_delay"
LATE = "torque_lag"
_STEP = 1e-6  # m, rad
_AXES = "xyz"
_PLACE = re.compile(r"(?:joint(\d+)\.)?([a-z_]+(?:\[[xyz]\])?)")

Correct = Callable[[Robot, int, float], Robot]


@dataclass(frozen=True)
class Description:
    """One quantity that a robot file states, at a joint (from 1).

    words     what is wrong when it is
    unit      of the correction;  largest: beyond it the linear column means nothing;  least: a smaller one is
              worth no name, as no data sheet tells it better;  least_samples: of a time, in sample periods,
              as rows do not tell at which moment of a cycle a drive reads what it logs
    correct   the robot whose quantity is larger by an amount; or what is said where no file states it
    turning   of revolute joints only;  rigid: of joints without hinges that bend
    positive  no correction is below 0
    whole     of the robot, not of a joint: it is listed at joint 1
    causal    a negative correction would be ahead of its time, as no sensor is: named by its share
    relative  to the other joints': where there are none, bodies make up for it
    measured  of torques that are measured: a known controller logs the one that it commands, in time
    served    of torques that follow from a servo's commands
    """

    name: str
    words: str
    unit: str
    largest: float
    correct: Correct | Outside
    turning: bool = False
    rigid: bool = False
    positive: bool = False
    whole: bool = False
    causal: bool = False
    measured: bool = False
    served: bool = False
    relative: bool = False
    least: float = 0.0
    least_samples: float = 0.0

    def worth_name(self, value: np.ndarray, period: float) -> bool:
        """Whether corrections are large enough in logs of a sample period [s]."""
        return bool(np.all(np.abs(value) >= max(self.least, self.least_samples * period)))


def _origin(axis: int) -> Correct:
    def correct(robot: Robot, k: int, amount: float) -> Robot:
        origin = np.array(robot.joints[k - 1].origin, float)
        origin[axis] += amount
        return _with_joint(robot, k, origin=tuple(origin.tolist()))

    return correct


def _axis(number: int) -> Correct:
    def correct(robot: Robot, k: int, amount: float) -> Robot:
        joint = robot.joints[k - 1]
        turn = Rotation.from_rotvec(amount * joint.triad[:, number])
        return _with_joint(robot, k, **_turned(joint, turn))

    return correct


def _tilt(number: int) -> Correct:
    def correct(robot: Robot, _: int, amount: float) -> Robot:
        turn = Rotation.from_rotvec(amount * np.eye(3)[number])
        return replace(robot, gravity=_vector(turn, robot.gravity))

    return correct


def _zero(robot: Robot, k: int, amount: float) -> Robot:
    """Everything behind joint k turned about its axis."""
    turn = Rotation.from_rotvec(amount * robot.joints[k - 1].triad[:, 0])
    behind = _behind(robot, k)
    joints = []
    for number, joint in robot.numbered:
        if number == k:
            joint = replace(joint, **_turned(joint, turn))
        elif number in behind:
            joint = replace(joint, origin=_vector(turn, joint.origin), **_turned(joint, turn))
        joints.append(joint)
    tip = _vector(turn, robot.tip) if robot.last_link in {k, *behind} else robot.tip
    return replace(robot, joints=tuple(joints), tip=tip)


DESCRIPTIONS: Mapping[str, Description] = {
    d.name: d
    for d in (
        *(
            Description(f"origin[{a}]", "the joint's origin", "m", 0.05, _origin(i))
            for i, a in enumerate("xyz")
        ),
        *(
            Description(f"axis[{a}]", f"the joint's axis, by a turn about its {a}'", "rad", 0.1, _axis(i))
            for i, a in ((1, "y"), (2, "z"))
        ),
        *(
            Description(f"base_tilt[{a}]", f"gravity, by a turn about {a}", "rad", 0.1, _tilt(i), whole=True)
            for i, a in enumerate("xyz")
        ),
        Description("encoder_zero", "where the encoder reads zero", "rad", 0.1, _zero, turning=True),
        Description(
            "gear_ratio", "how far the joint turns per unit that it logs", "1", 1.0, RATIO, least=0.002
        ),
        Description(
            "torque_gain", "the gain of the logged torque", "1", 1.0, GAIN, relative=True, least=0.01
        ),
        Description(
            LATE,
            "how late the logged torque comes",
            "s",
            0.02,
            LAG,
            causal=True,
            measured=True,
            least=5e-4,
            least_samples=0.2,
        ),
        Description(
            DELAY,
            "how late the servo answers a command",
            "s",
            0.02,
            ANSWER,
            causal=True,
            served=True,
            least=5e-4,
            least_samples=0.2,
        ),
        Description(
            DRIVE,
            "how far the drive bends under its load",
            "rad/(N m)",
            1.0,
            BEND,
            rigid=True,
            positive=True,
        ),
    )
}


def describes(name: str) -> bool:
    """Whether a name is that of a description, not of a law."""
    return name in DESCRIPTIONS


def stated(name: str) -> bool:
    """Whether a robot file states it: every law, and every description of the machine's geometry."""
    return outside_file(name) is None


def outside_file(name: str) -> Outside | None:
    """What is said of an error that no robot file states; None of all that one states."""
    correct = DESCRIPTIONS[name].correct if describes(name) else None
    return correct if isinstance(correct, Outside) else None


def description_names(robot: Robot, joint: int) -> list[str]:
    """What may be wrong at a joint (from 1) of a robot without loops and passive joints."""
    if robot.closures or robot.passive:
        return []
    own = robot.joints[joint - 1]
    tilts = [a for a, e in zip(_AXES, np.eye(3), strict=True) if np.cross(e, robot.gravity).any()]
    return [
        d.name
        for d in DESCRIPTIONS.values()
        if not (d.turning and own.kind != "revolute")
        and not (d.rigid and own.flexible)
        and not (d.measured and (robot.controller is not None or robot.servo is not None))
        and not (d.served and robot.servo is None)
        and not (d.relative and len(robot.joints) == 1)
        and not (d.whole and (joint != 1 or d.name.removesuffix("]")[-1] not in tilts))
    ]


def corrected(robot: Robot, joint: int, name: str, amount: float) -> Robot:
    """The robot with another description. Raises RobotError for a quantity that no robot file states."""
    correct = _described(robot, joint, name).correct
    if isinstance(correct, Outside):
        raise RobotError(f"{name} at joint {joint} stands in no robot file: {correct.mend.format(k=joint)}")
    return correct(robot, joint, amount)


def value_of(robot: Robot, joint: int, name: str) -> str:
    """The file's own value of a quantity, as text: a vector or an angle from what it was."""
    own = robot.joints[joint - 1]
    shown = {"origin": own.origin, "axis": own.x, "base_tilt": robot.gravity}.get(name.partition("[")[0])
    return "" if shown is None else "[" + ", ".join(f"{x:.6g}" for x in shown) + "]"


def parsed(robot: Robot, place: str) -> tuple[int, str]:
    """Joint and name of `joint3.origin[z]` or `base_tilt[x]`. Raises RobotError."""
    match = _PLACE.fullmatch(place)
    name = match[2] if match else ""
    if match is None or name not in DESCRIPTIONS or (match[1] is None) != DESCRIPTIONS[name].whole:
        raise RobotError(
            f"{place!r} is no quantity of a robot's description; write joint3.origin[z], joint2.axis[y], "
            "joint2.encoder_zero or base_tilt[x]"
        )
    joint = int(match[1] or 1)
    _described(robot, joint, name)
    return joint, name


def place_name(joint: int, name: str) -> str:
    """`joint3.origin[z]`, or `base_tilt[x]` of the robot as a whole."""
    return name if DESCRIPTIONS[name].whole else f"joint{joint}.{name}"


def description_column(
    robot: Robot, joint: int, name: str, motion: Motion, about: Springs = NO_SPRINGS
) -> dict[int, np.ndarray]:
    """Row -> (N,): ∂(Φ p)/∂θ at the robot's own parameters, per unit of the correction.

    about   springs of drives, the joint's last, whose whole effect is asked for in place of a slope
    """
    outside = outside_file(name)
    if outside is not None:
        return outside.column(robot, motion, joint, about)
    other = link_forces_along(corrected(robot, joint, name, _STEP), motion)
    return dict(enumerate((other - as_they_are(robot, motion)) / _STEP))


def _described(robot: Robot, joint: int, name: str) -> Description:
    if not 1 <= joint <= len(robot.joints):
        raise RobotError(f"robot {robot.name} has no joint {joint}; it has 1 to {len(robot.joints)}")
    if name not in description_names(robot, joint):
        raise RobotError(f"robot {robot.name} states no {name} at joint {joint} that could be corrected")
    return DESCRIPTIONS[name]


def _with_joint(robot: Robot, k: int, **changes: tuple[float, ...]) -> Robot:
    joint = replace(robot.joints[k - 1], **changes)  # pyright: ignore[reportArgumentType]
    return replace(robot, joints=(*robot.joints[: k - 1], joint, *robot.joints[k:]))


def _turned(joint: Joint, turn: Rotation) -> dict[str, tuple[float, ...]]:
    return {"x": _vector(turn, joint.x), "y": _vector(turn, joint.y)}


def _vector(turn: Rotation, v: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(np.asarray(turn.apply(v), float).tolist())


def _behind(robot: Robot, k: int) -> set[int]:
    """Numbers of the links that joint k moves besides its own."""
    found: set[int] = set()
    for number, parent in enumerate(robot.parents, start=1):
        if parent == k or parent in found:
            found.add(number)
    return found
