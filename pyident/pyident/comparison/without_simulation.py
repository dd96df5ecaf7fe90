"""What can be said of a model that cannot be simulated: how well its equations of motion fit the logs."""

from pathlib import Path

import numpy as np

from flexmodels.coordinate import is_motor, joint_name, joint_number
from pyident.comparison.errors import LogErrors
from pyident.comparison.model_against_replicas import Part, loads_of, residual
from pyident.comparison.trial import Trial
from pyident.estimation.estimator import weighted
from pyident.regression.equations import Problem
from pyident.regression.regressor import residual_of


def parts_without_simulation(trial: Trial) -> list[Part]:
    """What the model leaves of the judged logs; of a simulation nothing."""
    robot, logs = trial.robot, [r.log for r in trial.judged]
    conditioned = [trial.conditioned(log, robot) for log in logs]
    best = weighted(Problem(robot, tuple(conditioned)))
    refitted, p = best.problem.robot, best.solution.p
    return [
        Part(
            part,
            log.period,
            residual(robot, part),
            residual_of(refitted, part, p),
            np.zeros(0),
            {},
            loads_of(robot, part),
        )
        for part, log in zip(conditioned, logs, strict=True)
    ]


def sentence_without_simulation(reason: str, errors: tuple[LogErrors, ...]) -> str:
    """reason: why there is no simulation."""
    motors = [
        (error, name, log.log)
        for log in errors
        for name, error in log.equations.items()
        if is_motor(name) and error.signal > 0
    ]
    alone = f"The model cannot be simulated: {reason.rstrip('.')}. Its equations of motion are compared alone"
    if not motors:
        return f"{alone}, and no joint moves by which they could be judged."
    error, name, log = max(motors, key=lambda found: found[0].nrmse_percent)
    return (
        f"{alone}, without replicas and so without a floor: they leave most at "
        f"{joint_name(joint_number(name))}, "
        f"{error.nrmse_percent:.3g} % of the torque in {Path(log).name}."
    )
