"""Derivatives and the held torque: what each way of preparing the signals does to the parameters."""

from dataclasses import replace

import numpy as np
import pandas as pd

from flexmodels.robot import Robot
from pyident.conditioning import weak_form as conditioning
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimator import Estimator, ordinary, weighted
from pyident.estimation.least_squares import Solution
from pyident.logs.log import Log
from pyident.regression.equations import Problem

_KINDS = ("J_m", "coulomb", "viscous", "k[1]", "k[2]", "k[3]")
EXPLANATION = """
The torque is held between samples, so accelerations jump at every sample. The paper's eighth-order
central difference with the torque of the same instant takes neither into account. The weak form with the
hat function between neighbouring samples as test function needs no second derivative: its mean
acceleration is the second difference, exactly, and its mean torque the mean of two samples, exactly.
Leaving out the equations of a joint near its reversals, where friction is not known, and weighing every
coordinate by what it leaves does the rest. It is the default for robots with a digital controller.
"""


def compare(robot: Robot, log: Log) -> pd.DataFrame:
    """One row per scheme: residual per joint and the largest error per kind of parameter [%]."""
    central = robot.with_settings(processing=replace(robot.settings.processing, derivative="central"))
    held, raw = condition(log, robot), condition(log, central)
    at_once = replace(raw, target=_sampled_torque(raw, log, robot))
    filtered = _filtered(raw)
    schemes = {
        "eighth-order central, torque of the same instant (plain)": (at_once, False, ordinary),
        "eighth-order central, mean torque": (raw, False, ordinary),
        "eighth-order central, mean torque, both sides filtered": (filtered, False, ordinary),
        "eighth-order central, mean torque, reversals left out": (raw, True, ordinary),
        "hat (weak form)": (held, False, ordinary),
        "hat (weak form), reversals left out": (held, True, ordinary),
        "hat (weak form), reversals left out, weighted: the default": (held, True, weighted),
    }
    return pd.DataFrame([_row(name, robot, *choice) for name, choice in schemes.items()])


def _row(name: str, robot: Robot, part: Conditioned, leave_out: bool, estimator: Estimator) -> dict[str, str]:
    if not leave_out:
        part = replace(part, use=np.ones_like(part.use))
    solution = estimator(Problem(robot, (part,))).solution
    joints = slice(0, len(robot.joints))
    left = 100 * solution.residual[joints] / solution.signal[joints]
    worst = {f"{kind} [%]": f"{_worst(robot, solution, kind):.2g}" for kind in _KINDS}
    return {"scheme": name, "residual per joint [%]": ", ".join(f"{v:.2g}" for v in left)} | worst


def _worst(robot: Robot, solution: Solution, kind: str) -> float:
    return max(
        abs(100 * (solution.p[i] / true - 1))
        for i, (name, true) in enumerate(robot.parameters.items())
        if name.endswith("." + kind) and not solution.open[i]
    )


def _sampled_torque(part: Conditioned, log: Log, robot: Robot) -> np.ndarray:
    target = part.target.copy()
    reach = conditioning.REACH
    target[:, : len(robot.joints)] = log.signals(list(robot.torques))[reach:-reach]
    return target


def _filtered(part: Conditioned) -> Conditioned:
    """Both sides of the equations through the same low-pass (the thinning filter, factor 2: 50 Hz)."""
    return replace(part, thinning=2)
