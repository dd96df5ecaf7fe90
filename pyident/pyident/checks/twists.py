"""Deformations in another sign, unit or order, from the motors' own balance and from that of the links."""

from collections.abc import Iterator

import numpy as np

from flexmodels.robot import parameter_name
from pyident.checks.balances import Balances, solved
from pyident.checks.defect import Defect
from pyident.rules.log_checks import LOG_CHECKS

_COLOURED = 2.0  # times the standard deviation of white residuals


def twists(of: Balances, source: str) -> Iterator[Defect]:
    """Of every motor that turns against a flexible hinge: τ = J_m ë + friction − k ε − d ε̇."""
    robot = of.samples.robot
    flexible = [k for k in of.joints if robot.joints[k].flexible]
    angle = {k: of.samples.q[:, robot.coordinates.index(f"joint{k + 1}.eps[1]")] for k in flexible}
    for k in flexible:
        name = f"joint{k + 1}.eps[1]"
        stiffness, std, left = _spring(of, k, angle[k])
        others = {j: _spring(of, k, angle[j])[2] for j in flexible if j != k}
        _, _, as_link = _spring(of, k, angle[k] - of.samples.q[:, k])
        nominal = robot.parameters.get(parameter_name(k + 1, "stiffness", "k[1]"), 0.0)
        off = stiffness / nominal if nominal > 0 else 1.0
        if stiffness < -LOG_CHECKS.sure * std:
            yield _defect("gross", "sign", source, name, "has the wrong sign: the joint would be of negative "
                          "stiffness; give its column the sign -1 in the mapping")  # fmt: skip
        elif left > LOG_CHECKS.material**2 and as_link < LOG_CHECKS.far_better * left:
            yield _defect("gross", "kind", source, name, "looks like the link's angle and not like the "
                                                         "twist; "
                          f"map it to joint{k + 1}.link")  # fmt: skip
        elif left > LOG_CHECKS.material**2 and min(others.values(), default=1.0) < LOG_CHECKS.better * left:
            other = min(others, key=lambda j: others[j])
            yield _defect("gross", "order", source, name, f"fits joint {k + 1} worse than "
                                                          f"joint{other + 1}.eps"
                          "[1] does; check the order of the columns")  # fmt: skip
        elif stiffness > LOG_CHECKS.sure * std and not 1 < off * LOG_CHECKS.stiffness_doubtful < (
            LOG_CHECKS.stiffness_doubtful**2
        ):
            gross = not 1 < off * LOG_CHECKS.stiffness_gross < LOG_CHECKS.stiffness_gross**2
            yield _defect("gross" if gross else "doubtful", "unit", source, name, f"gives a stiffness "
                                                                                  f"{off:.3g} "
                          "times the robot file's; check its unit (rad) and that of the torque")  # fmt: skip


def bends(of: Balances, source: str) -> Iterator[Defect]:
    """Bending that would push the wrong way in the balances of motors and links together."""
    robot = of.samples.robot
    rows = [c for c in robot.coordinates if ".eps[" in c]
    names = [c for c in rows if not c.endswith("[1]")]
    if not names or len(of.joints) < len(robot.joints):
        return
    variance = [max(of.variance(k), 1e-300) for k in range(len(robot.joints))]
    owner = [*range(len(robot.joints)), *(int(c.split(".")[0].removeprefix("joint")) - 1 for c in rows)]
    normal = sum(of.normal[row] / variance[k] for row, k in enumerate(owner))
    right = sum(of.right(k, of.torque[:, k : k + 1])[0] / variance[k] for k in of.joints)
    p, inverse = solved(np.asarray(normal), np.asarray(right))
    energy = max(len(of.joints) - float(np.asarray(right)[:, 0] @ p[:, 0]), 1e-9)
    spread = energy / (len(of.Phi) * len(owner))
    for name in names:
        k, i = name.removeprefix("joint").split(".eps")
        at = of.columns.index(parameter_name(int(k), "stiffness", f"k{i}"))
        std = _COLOURED * float(np.sqrt(max(inverse[at, at], 0.0) * spread))
        if p[at, 0] < -LOG_CHECKS.sure * std:
            yield _defect("gross", "sign", source, name, "has the wrong sign: the joint would be of negative "
                          "stiffness; give its column the sign -1 in the mapping")  # fmt: skip


def _defect(severity, kind: str, source: str, name: str, text: str) -> Defect:
    return Defect(severity, kind, name, f"{source}: {name} {text}")


def _spring(of: Balances, k: int, twist: np.ndarray) -> tuple[float, float, float]:
    """Stiffness, its standard deviation and the share of the torque's variance that motor k leaves."""
    signals, used = of.samples, of.samples.use[:, k] > 0
    de, dde = signals.dq[:, k], signals.ddq[:, k]
    rate = np.gradient(twist, signals.at * signals.period)
    columns = np.column_stack([-twist, -rate, dde, np.sign(de), de, np.ones(len(de))])[used]
    y = of.torque[used, k]
    p, inverse = solved(columns.T @ columns, columns.T @ y)
    energy = float(np.square(y - columns @ p).sum())
    std = _COLOURED * np.sqrt(max(inverse[0, 0] * energy / max(len(y) - 6, 1), 0.0))
    return float(p[0]), float(std), energy / max(of.variance(k), 1e-300)
