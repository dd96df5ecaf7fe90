"""Deformations in another sign, unit or order, from the motors' own balance and from that of the links."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import deformation_of, of_joint
from flexmodels.joint import parameter_name
from pyident.checks.balances import Balances, solved
from pyident.checks.defect import Defect
from pyident.checks.signs import inertia
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.log_checks import LOG_CHECKS


def twists(of: Balances, source: str) -> Iterator[Defect]:
    """Of every motor that turns against a flexible hinge: τ = J_m ë + friction − k ε − d ε̇."""
    robot = of.samples.robot
    flexible = [k for k in of.joints if robot.joints[k].flexible]
    angle = {k: of.samples.q[:, robot.coordinates.index(deformation_of(k + 1))] for k in flexible}
    for k in flexible:
        if (defect := _judged(of, k, angle, source)) is not None:
            yield defect


def _judged(of: Balances, k: int, angle: dict[int, np.ndarray], source: str) -> Defect | None:
    """What is wrong with the twist of joint k (from 0), of all those that were logged."""
    name = deformation_of(k + 1)
    stiffness, std, left = _spring(of, k, angle[k])
    if stiffness < -LOG_CHECKS.sure * std:
        together = _Together.of(of)
        row = of.samples.robot.coordinates.index(name)
        # an arm that shakes faster than it is sampled may bend either way
        believed = together is None or (together.negative(row) and together.fits(row))
        return _negative(source, name) if believed else None
    if left > LOG_CHECKS.material**2:
        as_link = _spring(of, k, angle[k] - of.samples.q[:, k])[2]
        # what fits the joint that it is logged at is of that joint, whatever else it fits
        astray = [j for j, own in angle.items() if j != k and _spring(of, j, own)[2] > LOG_CHECKS.material**2]
        others = {j: _spring(of, k, angle[j])[2] for j in astray}
        other = min(others, key=lambda j: others[j], default=k)
        if as_link < LOG_CHECKS.far_better * left:
            link = of_joint(k + 1, "link")
            text = f"looks like the link's angle and not like the twist; map it to {link}"
            return Defect("gross", "kind", name, f"{source}: {name} {text}")
        if others and others[other] < LOG_CHECKS.better * left:
            text = (
                f"fits joint {k + 1} worse than {deformation_of(other + 1)} does; check the order of columns"
            )
            return Defect("gross", "order", name, f"{source}: {name} {text}")
    nominal = of.samples.robot.parameters.get(parameter_name(k + 1, "stiffness", "k[1]"), 0.0)
    if nominal <= 0 or stiffness < LOG_CHECKS.sure * std or stiffness <= 0:
        return None
    factor = stiffness / nominal
    size = max(factor, 1 / factor)
    if size < LOG_CHECKS.stiffness_doubtful:
        return None
    text = (
        f"gives a stiffness {factor:.3g} times the robot file's; check its unit (rad) and that of the torque"
    )
    severity = "gross" if size > LOG_CHECKS.stiffness_gross else "doubtful"
    return Defect(severity, "unit", name, f"{source}: {name} {text}")


def bends(of: Balances, source: str) -> Iterator[Defect]:
    """Bending that would push the wrong way in the balances of motors and links together.

    A link's balance has no torque in it: a fit may turn the signs of its stiffness and of its inertia
    together, and nothing but a stiffness below zero beside an inertia above tells of a channel. With the
    channel's other sign all else stays, so where a spring leaves most of its moment something else is wrong,
    such as axes that are turned, or a unit.
    """
    together = _Together.of(of)
    if together is None:
        return
    for row, c in enumerate(of.samples.robot.q):
        if c.side != "link" or not together.negative(row):
            continue
        if together.deviations(inertia(of, row)) > LOG_CHECKS.sure:
            yield _negative(source, c.name) if together.fits(row) else _neither(source, c.name)


@dataclass(frozen=True)
class _Together:
    """One set of parameters p (P,) in the balances of all motors and links; covariance (P, P)."""

    balances: Balances
    p: np.ndarray
    covariance: np.ndarray

    @classmethod
    def of(cls, balances: Balances) -> "_Together | None":
        """None where the torque of a joint is not logged."""
        robot, joints = balances.samples.robot, balances.joints
        if len(joints) < len(robot.joints):
            return None
        variance = [max(balances.variance(k), 1e-300) for k in joints]
        normal = sum(balances.normal[row] / variance[c.joint - 1] for row, c in enumerate(robot.q))
        right = sum(balances.right(k, balances.torque[:, k : k + 1])[0] / variance[k] for k in joints)
        p, inverse = solved(np.asarray(normal), np.asarray(right))
        energy = max(len(joints) - float(np.asarray(right)[:, 0] @ p[:, 0]), 1e-9)
        spread = EQUATIONS.coloured**2 * energy / (len(balances.Phi) * len(robot.q))
        return cls(balances, p[:, 0], spread * inverse)

    def deviations(self, row: np.ndarray) -> float:
        """Of a combination of parameters from zero, in units of its own."""
        return float(row @ self.p) / max(float(np.sqrt(max(row @ self.covariance @ row, 0.0))), 1e-300)

    def negative(self, row: int) -> bool:
        """Whether the spring of an equation is below zero for sure."""
        return self.deviations(self._spring(row)) < -LOG_CHECKS.sure

    def fits(self, row: int) -> bool:
        """Whether an equation leaves little of the moment of its spring."""
        spring, balance = self._spring(row) * self.p, self.balances.normal[row]
        return bool(self.p @ balance @ self.p < LOG_CHECKS.far_better * (spring @ balance @ spring))

    def _spring(self, row: int) -> np.ndarray:
        name = str(self.balances.samples.robot.q[row].stiffness)
        return np.array([float(column == name) for column in self.balances.columns])


def _negative(source: str, name: str) -> Defect:
    text = "has the wrong sign: the joint would be of negative stiffness; give its column the sign -1"
    return Defect("gross", "sign", name, f"{source}: {name} {text}")


def _neither(source: str, name: str) -> Defect:
    text = (
        "fits with neither sign: check its unit, those of the motors, and the axes of its joint in the robot "
        "file (x and y)"
    )
    return Defect("doubtful", "sign", name, f"{source}: {name} {text}")


def _spring(of: Balances, k: int, twist: np.ndarray) -> tuple[float, float, float]:
    """Stiffness, its standard deviation and the share of the torque's variance that motor k leaves."""
    signals, used = of.samples, of.samples.use[:, k] > 0
    de, dde = signals.dq[:, k], signals.ddq[:, k]
    rate = np.gradient(twist, signals.at * signals.period)
    columns = np.column_stack([-twist, -rate, dde, np.sign(de), de, np.ones(len(de))])[used]
    y = of.torque[used, k]
    p, inverse = solved(columns.T @ columns, columns.T @ y)
    energy = float(np.square(y - columns @ p).sum())
    std = EQUATIONS.coloured * np.sqrt(max(inverse[0, 0] * energy / max(len(y) - 6, 1), 0.0))
    return float(p[0]), float(std), energy / max(of.variance(k), 1e-300)
