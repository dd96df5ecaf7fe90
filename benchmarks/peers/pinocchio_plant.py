"""The robot in Pinocchio: forward dynamics by pin.aba, classical Runge-Kutta in Python.

A flexible hinge is three revolute joints with massless bodies between, about z', -y' and x', with springs and
dampers; they equal the deformations to first order (see mujoco_plant). Coulomb friction has a mode per motor
hinge: the sign of its speed, or stuck. A step in which a joint reverses is taken again up to the reversal
(one linear interpolation), where the joint sticks; a stuck joint whose reaction exceeds the Coulomb level is
released at the end of a step. A stuck joint has an armature of 1e12 kg m2, and its reaction is that times its
acceleration.
"""

import time

import numpy as np
from studies.rigid_arm.pinocchio_chain import body, pinocchio

from flexmodels.coordinate import of_joint
from flexmodels.joint import Joint
from flexmodels.robot import Robot

pin = pinocchio()
_HELD = 1e12
_SHORTEST = 1e-3  # of a step, so that a reversal at its very beginning is passed
TURNS = ("e", "eps[2]", "eps[3]", "eps[1]")


class PinocchioPlant:
    """A robot of revolute joints with three deformations each, in a chain; `step` [s]."""

    def __init__(self, robot: Robot, step: float):
        assert robot.controller is not None
        self.model = pinocchio_model(robot)
        self.data, self.robot = self.model.createData(), robot
        self.steps = round(robot.controller.period / step)
        self.h = robot.controller.period / self.steps
        names = [of_joint(k, n) for k, _ in robot.numbered for n in TURNS]
        self.place = np.array([names.index(name) for name in robot.coordinates])
        self.motors = self.place[: len(robot.joints)]
        self.armature = np.array([joint.values["motor_inertia"]["J_m"] for joint in robot.joints])
        self.coulomb = np.array([joint.values["coulomb"]["coulomb"] for joint in robot.joints])
        self.k, self.d = np.array([laws for joint in robot.joints for laws in _springs(joint)]).T
        self.tip_place = pin.SE3(robot.joints[-1].triad.T, np.zeros(3)).act(np.array(robot.tip))
        self.reset(np.zeros(len(self.place)))

    def reset(self, q: np.ndarray) -> None:
        self.q, self.v = np.zeros(len(q)), np.zeros(len(q))
        self.q[self.place] = q
        self.mode, self.force = np.zeros(len(self.motors)), np.zeros(len(q))

    def advance(self, torque: np.ndarray) -> None:
        self._settle(torque)
        for _ in range(self.steps):
            left = self.h
            while left > 0:
                left -= self._step(left, torque)

    def angles(self) -> np.ndarray:
        return self.q[self.motors]

    def tip(self) -> np.ndarray:
        pin.forwardKinematics(self.model, self.data, self.q)
        return self.data.oMi[self.model.njoints - 1].act(self.tip_place)

    def seconds_per_call(self, calls: int = 10000) -> float:
        """CPU time of one pin.aba [s], its call from Python included."""
        force = self.force.copy()
        begin = time.process_time()
        for _ in range(calls):
            pin.aba(self.model, self.data, self.q, self.v, force)
        return (time.process_time() - begin) / calls

    def acceleration(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return pin.aba(self.model, self.data, q, v, self.force - self.k * q - self.d * v)

    def _step(self, h: float, torque: np.ndarray) -> float:
        """A step of length h, or up to the first reversal; returns how far it went."""
        q, v = self._runge_kutta(h)
        before, after = self.v[self.motors], v[self.motors]
        reverses = (self.coulomb > 0) & (self.mode * after < 0)
        if reverses.any():
            share = np.full(len(before), np.inf)
            share[reverses] = before[reverses] / (before - after)[reverses]
            first = share == share.min()
            h *= max(share.min(), _SHORTEST)
            q, v = self._runge_kutta(h)
            v[self.motors[first]] = self.mode[first] = 0
        self.q, self.v = q, v
        if not self.mode.all():
            self._settle(torque)
        return h

    def _runge_kutta(self, h: float) -> tuple[np.ndarray, np.ndarray]:
        q, v = self.q, self.v
        a1 = self.acceleration(q, v)
        v2 = v + h / 2 * a1
        a2 = self.acceleration(q + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = self.acceleration(q + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = self.acceleration(q + h * v3, v4)
        return q + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

    def _settle(self, torque: np.ndarray) -> None:
        """Release stuck joints, the most overloaded first, until every reaction is within its level."""
        free = self.coulomb == 0
        self.mode[free] = np.where(self.v[self.motors][free] < 0, -1, 1)
        for _ in range(len(self.mode) + 1):
            stuck = self.mode == 0
            self.force[self.motors] = torque - self.coulomb * self.mode
            self.model.armature[self.motors] = np.where(stuck, _HELD, self.armature)
            if not stuck.any():
                return
            reaction = _HELD * self.acceleration(self.q, self.v)[self.motors]
            overload = np.where(stuck, np.abs(reaction) - self.coulomb, -np.inf)
            worst = int(np.argmax(overload))
            if overload[worst] <= 0:
                return
            self.mode[worst] = np.sign(reaction[worst])


def pinocchio_model(robot: Robot):
    """pin.Model with the joints e, eps[2], eps[3], eps[1] of every joint of the robot."""
    model, end, axes = pin.Model(), 0, np.eye(3)
    model.gravity.linear = np.array(robot.gravity)
    for (k, joint), link in zip(robot.numbered, robot.links, strict=True):
        place = pin.SE3(axes.T @ joint.triad, axes.T @ np.array(joint.origin))
        minus_y = pin.JointModelRevoluteUnaligned(0.0, -1.0, 0.0)
        for name, turn in zip(
            TURNS, (pin.JointModelRX(), pin.JointModelRZ(), minus_y, pin.JointModelRX()), strict=True
        ):
            end = model.addJoint(end, turn, place, of_joint(k, name))
            place = pin.SE3.Identity()
        model.appendBodyToJoint(end, body(link, joint.triad), place)
        axes = joint.triad
    return model


def _springs(joint: Joint) -> list[tuple[float, float]]:
    """Stiffness and damping per turn; the motor has the viscous friction."""
    law = joint.values
    flexible = [(law["stiffness"][f"k[{i}]"], law["damping"][f"d[{i}]"]) for i in (2, 3, 1)]
    return [(0.0, law["viscous"]["viscous"]), *flexible]
