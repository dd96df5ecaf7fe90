"""What a format that cannot hold every law costs: the torque error on a log, with and without those laws."""

from dataclasses import dataclass

import numpy as np

from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.logs.log import Log
from pyident.regression.regressor import regressor


@dataclass(frozen=True)
class ExportCost:
    """Relative torque error [%] of the motors, rms over all joints.

    all_laws   of the model;  kept   of what the format keeps, its values unchanged;  lost   names of the laws
    """

    all_laws: float
    kept: float
    lost: tuple[str, ...]

    @property
    def sentence(self) -> str:
        if not self.lost:
            return f"nothing is lost: the torque error stays {self.all_laws:.3g} %"
        return (
            f"the torque error is {self.all_laws:.3g} % with every law and {self.kept:.3g} % "
            f"without {', '.join(self.lost)}"
        )


def cost_of_export(robot: Robot, log: Log, kept: frozenset[str]) -> ExportCost:
    """Predict the log's torques with every law and with only those in `kept`. Raises LogError.

    The stiffness of a hinge that is locked takes no torque of the motor and is not counted as lost.
    """
    part = condition(log, robot)
    matrix = regressor(robot, part.motion).matrix
    values = robot.linear_parameters
    lost = sorted({law for joint in robot.joints for law in joint.values} - kept - {"stiffness", "damping"})
    gone = {
        parameter_name(k, law, p.name)
        for k, joint in robot.numbered
        for law in lost
        if law in joint.values
        for p in joint.catalogue[law].parameters
    }
    p = np.array(list(values.values()))
    fewer = np.array([0.0 if name in gone else v for name, v in values.items()])
    motors = slice(0, len(robot.joints))
    scale = np.linalg.norm(part.all_used(part.target)[:, motors])
    left = [part.all_used(part.target - matrix @ v)[:, motors] for v in (p, fewer)]
    errors = [100 * float(np.linalg.norm(r) / scale) for r in left]
    return ExportCost(errors[0], errors[1], tuple(law for law in lost if _acts(robot, law)))


def _acts(robot: Robot, law: str) -> bool:
    return any(any(joint.values.get(law, {}).values()) for joint in robot.joints)
