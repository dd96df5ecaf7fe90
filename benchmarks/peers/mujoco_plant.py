"""The robot in MuJoCo.

One body per link with four hinge joints, which MuJoCo turns one behind the other: the motor hinge about x'
(armature J_m, viscous damping, frictionloss), then the flexible hinge about z', about -y' and about x' with
stiffness and damping. For small deformations these three are eps[2], eps[3] and eps[1]; the difference is of
second order in the deformations and shows as the error that remains at small steps.

Frictionloss is not Coulomb's law but a soft constraint. At MuJoCo's own settings a stuck joint creeps (its
speed decays with the time constant 0.02 s of solreffriction, and the impedance 0.9 of solimpfriction lets
10 % of the acceleration through); `stiff` sets them to twice the step and to 0.9999, MuJoCo's limits.

Solver PGS without islands: of the settings tried the fastest here (33 against 23 times real time with Newton
at 0.5 ms), with the same motion.
"""

# MuJoCo's compiled module has no types.
# pyright: reportAttributeAccessIssue=false

from dataclasses import dataclass
from typing import Literal
from xml.etree import ElementTree as ET

import mujoco  # pyright: ignore[reportMissingImports]
import numpy as np

from flexmodels.coordinate import of_joint
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.robot import Robot

HINGE = ("e", "eps[2]", "eps[3]", "eps[1]")  # the order in which they turn


Integrator = Literal["RK4", "implicitfast"]


@dataclass(frozen=True)
class Settings:
    """Integrator, step [s] and whether frictionloss is as stiff as MuJoCo allows."""

    integrator: Integrator
    step: float
    stiff: bool = False


class MujocoPlant:
    """A robot of revolute joints with three deformations each, in a chain."""

    def __init__(self, robot: Robot, settings: Settings):
        assert robot.controller is not None
        self.model = mujoco.MjModel.from_xml_string(mjcf(robot, settings))
        self.data = mujoco.MjData(self.model)
        self.steps = round(robot.controller.period / settings.step)
        names = [of_joint(k, n) for k, _ in robot.numbered for n in HINGE]
        self.place = [names.index(name) for name in robot.coordinates]
        self.motors = np.array(self.place[: len(robot.joints)])

    def reset(self, q: np.ndarray) -> None:
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[self.place] = q

    def advance(self, torque: np.ndarray) -> None:
        self.data.qfrc_applied[self.motors] = torque
        mujoco.mj_step(self.model, self.data, nstep=self.steps)

    def angles(self) -> np.ndarray:
        return self.data.qpos[self.motors]

    def tip(self) -> np.ndarray:
        mujoco.mj_kinematics(self.model, self.data)
        return self.data.site_xpos[0].copy()


def mjcf(robot: Robot, settings: Settings) -> str:
    """MuJoCo's XML of the robot; a link's frame has base axes in the zero pose, as ours."""
    root = ET.Element("mujoco", model=robot.name)
    ET.SubElement(root, "compiler", angle="radian")
    option = ET.SubElement(
        root,
        "option",
        integrator=settings.integrator,
        timestep=repr(settings.step),
        solver="PGS",
        gravity=_text(robot.gravity),
    )
    dry = any(joint.values["coulomb"]["coulomb"] for joint in robot.joints)
    constraint = "enable" if dry else "disable"
    ET.SubElement(option, "flag", contact="disable", island="disable", constraint=constraint)
    body = ET.SubElement(root, "worldbody")
    for (k, joint), link in zip(robot.numbered, robot.links, strict=True):
        body = ET.SubElement(body, "body", name=f"link{k}", pos=_text(joint.origin))
        for name, attributes in _hinges(joint, settings).items():
            ET.SubElement(body, "joint", attributes, name=of_joint(k, name))
        _add_inertia(body, link)
    ET.SubElement(body, "site", name="tip", pos=_text(robot.tip))
    return ET.tostring(root, encoding="unicode")


def _hinges(joint: Joint, settings: Settings) -> dict[str, dict[str, str]]:
    law, (x, y, z) = joint.values, joint.triad.T
    motor = {
        "axis": _text(x),
        "armature": repr(law["motor_inertia"]["J_m"]),
        "damping": repr(law["viscous"]["viscous"]),
        "frictionloss": repr(law["coulomb"]["coulomb"]),
    }
    if settings.stiff:
        motor["solreffriction"] = f"{2 * settings.step} 1"
        motor["solimpfriction"] = "0.9999 0.9999"
    flexible = {
        f"eps[{i}]": {
            "axis": _text(axis),
            "stiffness": repr(law["stiffness"][f"k[{i}]"]),
            "damping": repr(law["damping"][f"d[{i}]"]),
        }
        for i, axis in ((2, z), (3, -y), (1, x))
    }
    return {"e": motor} | flexible


def _add_inertia(body: ET.Element, link: Link) -> None:
    com, J = link.about_centre()
    full = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])
    ET.SubElement(body, "inertial", pos=_text(com), mass=repr(link.m), fullinertia=_text(full))


def _text(vector) -> str:
    return " ".join(repr(float(v)) for v in vector)
