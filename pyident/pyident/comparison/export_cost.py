"""What a format that cannot hold every law costs on a log: the error with and without those laws.

Of the torque, along the measured motion, where it was logged; else of the positions that a simulation in
closed loop reaches under the recorded commands.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import feedforward_of, motor_of
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.logs.log import Log, LogError
from pyident.regression.regressor import regressor
from pyident.simulation.recorded import loop_of, recorded
from pyident.simulation.simulator import Simulate

OpenRuns = Callable[[Robot], AbstractContextManager[Simulate]]


@dataclass(frozen=True)
class ExportCost:
    """Relative error [%] over all joints, rms.

    all_laws   of the model;  kept   of what the format keeps, its values unchanged;  lost   names of the laws
    measured   what it is of: "torque" of the motors, or "position" in closed loop, against its own movement
    """

    all_laws: float
    kept: float
    lost: tuple[str, ...]
    measured: str = "torque"

    @property
    def sentence(self) -> str:
        error = "torque error" if self.measured == "torque" else "position error in closed loop"
        if not self.lost:
            return f"nothing is lost: the {error} stays {self.all_laws:.3g} %"
        return (
            f"the {error} is {self.all_laws:.3g} % with every law and {self.kept:.3g} % "
            f"without {', '.join(self.lost)}"
        )


def cost_of_export(robot: Robot, log: Log, kept: frozenset[str], open_runs: OpenRuns) -> ExportCost:
    """Predict the log with every law and with only those in `kept`.

    open_runs   simulations of a robot; used where no torque was logged
    The stiffness of a hinge that is locked takes no torque of the motor and is not counted as lost.
    Raises LogError for a log with neither torques nor the commands of a loop that the robot file knows.
    """
    lost = sorted({law for joint in robot.joints for law in joint.values} - kept - {"stiffness", "damping"})
    gone = {
        parameter_name(k, law, p.name): 0.0
        for k, joint in robot.numbered
        for law in lost
        if law in joint.values
        for p in joint.catalogue[law].linear
    }
    named = tuple(law for law in lost if _acts(robot, law))
    if any(name in log.frame for name in robot.torques):
        whole, fewer = _torque_errors(robot, log, gone)
        return ExportCost(whole, fewer, named)
    whole, fewer = _position_errors(robot, log, gone, open_runs)
    return ExportCost(whole, fewer, named, "position")


def _torque_errors(robot: Robot, log: Log, gone: dict[str, float]) -> list[float]:
    """With every law, and with some parameters at zero [%]."""
    part = condition(log, robot)
    matrix = regressor(robot, part.motion).matrix
    motors = slice(0, len(robot.joints))
    scale = np.linalg.norm(part.all_used(part.target)[:, motors])
    sets = [robot.linear_parameters, robot.linear_parameters | gone]
    left = [part.all_used(part.target - matrix @ np.array(list(p.values())))[:, motors] for p in sets]
    return [100 * float(np.linalg.norm(r) / scale) for r in left]


def _position_errors(robot: Robot, log: Log, gone: dict[str, float], open_runs: OpenRuns) -> list[float]:
    """The same of positions: each joint's error over what it moves [%]."""
    positions = [motor_of(k) for k, _ in robot.numbered]
    added = [feedforward_of(k) for k, _ in robot.numbered] if robot.controller else []
    missing = [name for name in (*positions, *added) if name not in log.frame]
    if missing:
        raise LogError(
            f"{log.source}: it has no torques, and {missing[0]} is missing, without which a simulation in "
            "closed loop cannot take their place; add the column"
        )
    obstacle = loop_of(robot, log)
    if obstacle:
        raise LogError(f"{log.source}: it has no torques and cannot be simulated in closed loop: {obstacle}")
    inputs, measured = recorded(robot, log), log.signals(positions)
    with open_runs(robot) as simulate:
        frames = list(simulate(inputs.plan, [robot.parameters, robot.parameters | gone]))
    moved = np.maximum(measured.std(axis=0), 1e-300)
    missed = [inputs.cut(frame)[positions].to_numpy() - measured for frame in frames]
    return [100 * float(np.sqrt(np.mean((m / moved) ** 2))) for m in missed]


def _acts(robot: Robot, law: str) -> bool:
    return any(any(joint.values.get(law, {}).values()) for joint in robot.joints)
