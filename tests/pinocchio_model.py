"""An oracle: the same robot in Pinocchio, whose joints share nothing with our hinge elements.

A flexible hinge becomes three revolute joints with massless bodies between them: about z' by beta, about
−y' by gamma, about x' by alpha. They reach the same frame as the deformations (eps1, eps2, eps3) when

    sin(gamma) = eps3,   sin(beta) = eps2 / cos(gamma),   alpha = eps1 + delta(eps2, eps3)

where delta is the turn about x' between Rz(beta) Ry(−gamma) and the shortest rotation of the hinge element.
With z the angles: dz = T dq, ddz = T ddq + c; forces go back with Tᵀ. T and c come from CasADi.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import casadi as ca
import numpy as np
import pytest
from studies.rigid_arm.pinocchio_chain import body

from flexmodels.files.robot_file import load_robot
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.loops.linkage import PassiveJoint
from flexmodels.robot import Robot

pin = pytest.importorskip("pinocchio", reason="Pinocchio (package pin) is the oracle and is not installed")


@dataclass(frozen=True)
class NodeMotion:
    """A link's frame at its joint, base axes: x, v, a, w, dw (3,), R (3, 3), DF (6, n)."""

    x: np.ndarray
    R: np.ndarray
    v: np.ndarray
    w: np.ndarray
    a: np.ndarray
    dw: np.ndarray
    DF: np.ndarray


class PinocchioRobot:
    """A robot of ours in Pinocchio, with branches and with passive joints that follow.

    Every method takes vectors in the order of `robot.coordinates`.
    """

    def __init__(self, robot: Robot):
        self.robot = robot
        self.model = pin.Model()
        self.model.gravity.linear = np.array(robot.gravity)
        joints = (*robot.joints, *robot.passive)
        ends, self.triads = {0: 0}, [joint.triad for joint in joints]
        places: dict[int, list[int]] = {}  # per link those of its joint and of the turns behind it
        for k in _depth_first(robot):
            before, triad = robot.parents[k - 1], self.triads[k - 1]
            axes = self.triads[before - 1] if before else np.eye(3)
            place = pin.SE3(axes.T @ triad, axes.T @ np.array(joints[k - 1].origin))
            end, places[k] = ends[before], []
            for turn in _joint_models(joints[k - 1]):
                end = self._add(end, turn, place)
                places[k].append(end - 1)
                place = pin.SE3.Identity()
            self.model.appendBodyToJoint(end, body(robot.links[k - 1], triad), pin.SE3.Identity())
            ends[k] = end
        self.ends = [ends[k] for k in sorted(places)]
        driven, passive = sorted(places)[: len(robot.joints)], sorted(places)[len(robot.joints) :]
        hinges = [i for k in driven for i in places[k][1:]]
        # per angle of z, in our order (every e, every eps, the passive ones), its place in Pinocchio's q
        self.order = [places[k][0] for k in driven] + hinges + [places[k][0] for k in passive]
        self.data = self.model.createData()

    def nodes(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> list[NodeMotion]:
        """Per link the motion of its node."""
        z, T, c = self._angles(q, dq)
        pin.forwardKinematics(self.model, self.data, z, T @ dq, T @ ddq + c)
        pin.computeJointJacobians(self.model, self.data, z)
        world = pin.LOCAL_WORLD_ALIGNED
        motions = []
        for end, triad in zip(self.ends, self.triads, strict=True):
            frame = self.data.oMi[end]
            velocity = pin.getVelocity(self.model, self.data, end, world)
            acceleration = pin.getClassicalAcceleration(self.model, self.data, end, world)
            motions.append(
                NodeMotion(
                    x=frame.translation.copy(),
                    R=frame.rotation @ triad.T,
                    v=velocity.linear.copy(),
                    w=velocity.angular.copy(),
                    a=acceleration.linear.copy(),
                    dw=acceleration.angular.copy(),
                    DF=pin.getJointJacobian(self.model, self.data, end, world).reshape(6, -1) @ T,
                )
            )
        return motions

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        """M(q) of the links, without motor inertias."""
        z, T, _ = self._angles(q, np.zeros_like(q))
        M = pin.crba(self.model, self.data, z)
        M = np.triu(M) + np.triu(M, 1).T
        return T.T @ M @ T

    def potential_energy(self, q: np.ndarray) -> float:
        """Of gravity [J], at coordinates q (n,)."""
        angles, *_ = self._angles(q, np.zeros_like(q))
        return float(pin.computePotentialEnergy(self.model, self.data, angles))

    def inverse_dynamics(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> np.ndarray:
        """M ddq + h(q, dq): generalised forces of the links, gravity included."""
        z, T, c = self._angles(q, dq)
        return T.T @ pin.rnea(self.model, self.data, z, T @ dq, T @ ddq + c)

    def _add(self, parent: int, joint, place) -> int:
        return self.model.addJoint(parent, joint, place, f"joint{self.model.njoints}")

    def _angles(self, q: np.ndarray, dq: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pinocchio's q, T = dz/dq and c = (dT/dt) dq, in Pinocchio's order of joints."""
        z, T, c = (np.array(value) for value in self._map(q, dq))
        order = np.argsort(self.order)
        return z[order, 0], T[order], c[order, 0]

    @cached_property
    def _map(self) -> ca.Function:
        names, n = self.robot.coordinates, len(self.robot.coordinates)
        q, dq = ca.SX.sym("q", n), ca.SX.sym("dq", n)
        parts = [q[: len(self.robot.joints)]]
        for k, joint in self.robot.numbered:
            eps = [q[names.index(f"joint{k}.eps[{i}]")] for i in joint.deformations]
            parts += [_turns(*eps)] if len(eps) == 3 else eps
        for joint in self.robot.passive:
            angle = ca.SX(0)
            for k, factor in joint.follows.items():
                own = (name for name in (f"joint{k}.e", f"joint{k}.eps[1]") if name in names)
                angle += factor * sum(q[names.index(name)] for name in own)
            parts.append(angle)
        z = ca.vertcat(*parts)
        T = ca.jacobian(z, q)
        return ca.Function("angles", [q, dq], [z, T, ca.jtimes(T @ dq, q, dq)])


def _depth_first(robot: Robot, parent: int = 0) -> list[int]:
    """Numbers of the links, each branch to its end: the order that Pinocchio's algorithms ask for."""
    children = [k for k, before in enumerate(robot.parents, start=1) if before == parent]
    return [n for k in children for n in (k, *_depth_first(robot, k))]


def _joint_models(joint: Joint | PassiveJoint) -> list:
    if isinstance(joint, PassiveJoint):
        return [pin.JointModelRX()]
    motor = pin.JointModelRX() if joint.kind == "revolute" else pin.JointModelPX()
    bends = [pin.JointModelRZ(), pin.JointModelRY()] if joint.flexible and joint.bends else []
    return [motor, *bends, *([pin.JointModelRX()] if joint.flexible else [])]


def mixed_robot(seed: int = 0) -> Robot:
    """Tilted joints of every kind: flexible and rigid, revolute and prismatic; random bodies and laws."""
    rng = np.random.default_rng(seed)
    kinds: list[tuple[Literal["revolute", "prismatic"], bool]] = [
        ("revolute", True),
        ("revolute", False),
        ("prismatic", True),
        ("prismatic", False),
        ("revolute", True),
    ]
    joints, links = [], []
    for kind, flexible in kinds:
        triad = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        values = {"motor_inertia": {"J_m": 2.0}, "coulomb": {"coulomb": 3.0}, "viscous": {"viscous": 1.5}}
        if flexible:
            values["stiffness"] = {f"k[{i}]": 100.0 * i for i in (1, 2, 3)}
            values["damping"] = {f"d[{i}]": 2.0 * i for i in (1, 2, 3)}
        x, y, origin = (tuple(map(float, v)) for v in (triad[:, 0], triad[:, 1], rng.normal(size=3)))
        joints.append(Joint(kind=kind, x=x, y=y, origin=origin, flexible=flexible, values=values))
        root = rng.normal(size=(3, 3))
        links.append(Link.of_centre(rng.uniform(1, 9), rng.normal(size=3), root @ root.T))
    base = load_robot("four_link")
    return replace(base, name="mixed", joints=tuple(joints), links=tuple(links), controller=None)


def tree_robot(seed: int = 0, passive: int = 0) -> Robot:
    """The mixed robot's joints on branches, two of them only twisting; and hinges that follow the others."""
    rng = np.random.default_rng(seed + 100)
    robot = mixed_robot(seed)
    joints = [replace(j, parent=p) for j, p in zip(robot.joints, (0, 1, 1, 2, 0), strict=True)]
    for k in (0, 4):
        laws = joints[k].values
        one = {"stiffness": {"k[1]": 90.0}, "damping": {"d[1]": 3.0}}
        joints[k] = replace(joints[k], bends=False, values={**laws, **one})
    more = {5 + i: joint for i, joint in enumerate(mixed_robot(seed + 1).joints[:passive])}
    return replace(
        robot,
        name=f"tree_{seed}_{passive}",
        joints=tuple(joints),
        links=robot.links + mixed_robot(seed + 1).links[:passive],
        passive=tuple(
            PassiveJoint(
                j.x, j.y, j.origin, {2: rng.normal(), 5: rng.normal()}, parent=int(rng.integers(0, k))
            )
            for k, j in more.items()
        ),
        tip=(0.3, -0.2, 0.5),
        tip_link=4,
    )


def random_motion(robot: Robot, samples: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, dq, ddq (samples, n): large motor hinge angles (loops: far from flat), deformations up to 0.2."""
    rng = np.random.default_rng(seed)
    n, joints = len(robot.coordinates), len(robot.joints)
    q = rng.uniform(-0.2, 0.2, size=(samples, n))
    reach = 0.5 if robot.closures else 3.0
    q[:, :joints] = rng.uniform(-reach, reach, size=(samples, joints))
    return q, rng.uniform(-2, 2, size=(samples, n)), rng.uniform(-5, 5, size=(samples, n))


def _turns(eps1: ca.SX, eps2: ca.SX, eps3: ca.SX) -> ca.SX:
    """beta, −gamma and alpha of one flexible hinge."""
    gamma = ca.asin(eps3)
    beta = ca.asin(eps2 / ca.cos(gamma))
    inverse = 1 / (1 + ca.sqrt(1 - eps2**2 - eps3**2))
    y_of_B = ca.vertcat(-eps2, 1 - inverse * eps2**2, -inverse * eps2 * eps3)
    y = ca.vertcat(-ca.sin(beta), ca.cos(beta), 0)
    z = ca.vertcat(-ca.cos(beta) * ca.sin(gamma), -ca.sin(beta) * ca.sin(gamma), ca.cos(gamma))
    delta = ca.atan2(ca.dot(z, y_of_B), ca.dot(y, y_of_B))
    return ca.vertcat(beta, -gamma, eps1 + delta)
