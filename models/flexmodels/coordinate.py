"""Names of what belongs to a joint: its coordinates, the signals of a log, its parameters.

Every name reads `joint{k}.…` with k from 1. This file alone writes and reads such names.
"""

import re
from dataclasses import dataclass, field
from typing import Literal

Side = Literal["motor", "transmission", "link"]

_JOINT = re.compile(r"joint([1-9][0-9]*)")
_COORDINATE = re.compile(r"joint([1-9][0-9]*)\.(?:(e)|(eps)(?:\[([123])\]|([123])))")
_ORDERS = ("", "d", "dd")


@dataclass(frozen=True)
class Coordinate:
    """One entry of q: the motor hinge's `e`, or one deformation `eps[index]` of the flexible hinge.

    joint   from 1
    index   1 is the twist about the hinge's axis, 2 and 3 are its bending; 0 for `e`
    unit    "rad", or "m" where the joint slides
    """

    joint: int
    kind: Literal["e", "eps"]
    index: int = 0
    unit: str = field(default="rad", compare=False)

    @staticmethod
    def parse(name: str) -> "Coordinate":
        """Of a column (`joint2.eps[1]`) or a law's signal (`joint2.eps1`). Raises ValueError."""
        parts = _COORDINATE.fullmatch(name)
        if parts is None:
            raise ValueError(f"{name} is no coordinate; coordinates read joint1.e or joint1.eps[1]")
        k, motor, _, bracketed, plain = parts.groups()
        return Coordinate(int(k), "e") if motor else Coordinate(int(k), "eps", int(bracketed or plain))

    @property
    def name(self) -> str:
        """Column of a log and variable of an FMU: `joint2.eps[1]`."""
        return f"joint{self.joint}.{self.local}"

    @property
    def local(self) -> str:
        """The name without its joint: `eps[1]`."""
        return self.kind + (f"[{self.index}]" if self.index else "")

    @property
    def symbol(self) -> str:
        """What a law at this joint calls it: `eps1`."""
        return self.kind + (str(self.index) if self.index else "")

    @property
    def signal(self) -> str:
        """The symbol with its joint: `joint2.eps1`."""
        return self.rate(0)

    def rate(self, order: int) -> str:
        """Signal of the derivative of this order: `joint2.deps1` for 1."""
        return of_joint(self.joint, _ORDERS[order] + self.symbol)

    @property
    def side(self) -> Side:
        """Where its balance of forces is taken."""
        return "motor" if self.kind == "e" else "transmission" if self.index == 1 else "link"

    @property
    def is_motor(self) -> bool:
        return self.kind == "e"

    @property
    def force_unit(self) -> str:
        """Of the generalised force on it, in FMI's notation."""
        return "N" if self.unit == "m" else "N.m"

    @property
    def stiffness(self) -> str | None:
        """Name of the parameter that is its stiffness, None for `e`."""
        return of_joint(self.joint, f"k[{self.index}]") if self.index else None


def joint_name(joint: int) -> str:
    """`joint2`."""
    return f"joint{joint}"


def joint_number(name: str) -> int:
    """Of `joint2` or anything that begins with `joint2.`. Raises ValueError."""
    parts = _JOINT.fullmatch(name.partition(".")[0])
    if parts is None:
        raise ValueError(f"{name} belongs to no joint; such names begin with joint1, joint2, ...")
    return int(parts[1])


def of_joint(joint: int, what: str) -> str:
    """`joint2.what`."""
    return f"joint{joint}.{what}"


def signal_of(joint: int, symbol: str) -> str:
    """Signal behind the symbol of a law at a joint: `joint2.de`, `joint3.de` for `beyond.de`; or `time`."""
    if symbol == "time":
        return symbol
    if symbol.startswith("beyond."):
        return of_joint(joint + 1, symbol.removeprefix("beyond."))
    return of_joint(joint, symbol)


def divided(name: str) -> tuple[int, str]:
    """Joint and the rest of a name: (2, "stribeck.velocity"). Raises ValueError."""
    return joint_number(name), name.partition(".")[2]


def motor_of(joint: int) -> str:
    """Column of the motor's angle or position."""
    return of_joint(joint, "e")


def deformation_of(joint: int, index: int = 1) -> str:
    """Column of a deformation; without an index of the twist."""
    return of_joint(joint, f"eps[{index}]")


def torque_of(joint: int) -> str:
    """Column of the motor's torque [N m or N]."""
    return of_joint(joint, "tau")


def reference_of(joint: int) -> str:
    """Column of the controller's reference [rad or m]."""
    return of_joint(joint, "r")


def feedforward_of(joint: int) -> str:
    """Column of the feed-forward torque [N m or N]."""
    return of_joint(joint, "tau_ff")


def switch_of(joint: int) -> str:
    """Column of a servo's switch: 1 while it drives, 0 while its motor turns freely."""
    return of_joint(joint, "on")


def start_speed_of(joint: int) -> str:
    """Parameter of an FMU: the motor's speed at the start [rad/s or m/s]."""
    return of_joint(joint, "de_0")


def start_of(joint: int) -> str:
    """Parameter of an FMU: the motor's position at the start [rad or m]."""
    return of_joint(joint, "e_0")


def is_torque(name: str) -> bool:
    """Whether a column holds a motor's torque."""
    return re.fullmatch(r"joint[1-9][0-9]*\.tau", name) is not None


def is_deformation(name: str) -> bool:
    """Whether a column holds a deformation."""
    return re.fullmatch(r"joint[1-9][0-9]*\.eps\[[123]\]", name) is not None


def is_motor(name: str) -> bool:
    """Whether a column holds a motor's angle or position."""
    return re.fullmatch(r"joint[1-9][0-9]*\.e", name) is not None
