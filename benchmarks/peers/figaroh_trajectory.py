"""figaroh's optimal trajectory for a URDF: cubic splines whose waypoints IPOPT moves, condition number of the
base regressor as objective, under the URDF's limits of position, speed and effort.

It needs `cyipopt`, which pip builds against an installed IPOPT.
"""

import contextlib
import io
import random
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin  # pyright: ignore[reportMissingImports]

_CONFIG = """
robot:
  name: {name}
  properties:
    joints:
      active_joints: [{joints}]
    coupling: {{has_coupled_wrist: false}}
tasks:
  identification:
    problem:
      use_joint_torques: true
      model_components: {{friction: true, joint_offset: false, actuator_inertia: true}}
  optimal_trajectory:
    trajectory: {{waypoints: {waypoints}, frequency: {rate}, segment_duration: {between}}}
    problem: {{soft_lim: 0.0, max_iterations: {iterations}, segment_attempts: 3}}
"""


class Peer:
    """figaroh set up for a robot of revolute joints: its base columns, its trajectories."""

    def __init__(self, model, seconds: float, rate: float, segments: int, iterations: int):
        from figaroh.optimal.base_optimal_trajectory import (  # pyright: ignore[reportMissingImports]
            BaseOptimalTrajectory,
            BaseTrajectoryIPOPTProblem,
        )

        class Trajectory(BaseOptimalTrajectory):
            def create_ipopt_problem(self, *given):
                return BaseTrajectoryIPOPTProblem(self, *given)

        waypoints = 5
        joints = [name for name in model.names if name != "universe"]
        self.segments = segments
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "config.yaml"
            between = seconds / segments / (waypoints - 1)
            file.write_text(
                _CONFIG.format(
                    name=model.name,
                    joints=", ".join(joints),
                    waypoints=waypoints,
                    rate=rate,
                    between=between,
                    iterations=iterations,
                )
            )
            none = pin.GeometryModel()
            robot = pin.RobotWrapper(model, none, none)
            robot.q0 = pin.neutral(model)
            np.random.seed(0)  # noqa: NPY002 - figaroh draws from NumPy's global generator
            random.seed(0)
            with contextlib.redirect_stdout(io.StringIO()):
                self.trajectory = Trajectory(robot, joints, str(file))
                self.trajectory.identif_config["act_idxv"] = list(range(model.nv))
                self.trajectory.initialize()

    def solve(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """q, dq, ddq (samples, joints) of all segments; None where one of them failed."""
        with contextlib.redirect_stdout(io.StringIO()):
            found = self.trajectory.solve(stack_reps=self.segments)
        if len(found["T_F"]) < self.segments:
            return None
        q, dq, ddq = (np.vstack(found[name]) for name in ("P_F", "V_F", "A_F"))
        return q, dq, ddq

    def condition(self, q: np.ndarray, dq: np.ndarray, ddq: np.ndarray) -> float:
        """Of the base regressor along a motion."""
        return float(np.linalg.cond(self.trajectory._stack_base_regressors(q, dq, ddq)))
