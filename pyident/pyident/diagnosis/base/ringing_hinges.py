"""Dampings that a log cannot tell, so that replicas ring as loudly as the log does.

A hinge that vibrates faster than the samples can follow is shaken by every step of the controller, and its
vibration reaches the equations as noise, folded to any frequency. How much there is depends on its damping,
of which a regression finds nothing (a factor of 8 too much, or none). So replicas with more and with less
damping show how loud they are, and the damping is the one with which an equation of such a hinge keeps as
much as in the log. What else is missing in just these equations is then hidden as far as dampings within
a factor of a few could make it; all other equations stay as they are.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmodels.inputs import SimulationError
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.replicas import judged_replicas, left_of
from pyident.diagnosis.base.setting import Setting
from pyident.logs.log import Log
from pyident.refinement.instruments.instrumental_covariance import ringing
from pyident.simulation.simulator import Simulator, Workers

_FACTORS = (0.25, 1.0, 4.0)  # of the dampings found, in the replicas that show their part
_ROUNDS = 2  # hinges shake each other
_SEED = 100_000  # of none of the replicas that are judged
_SCATTER = 0.1  # of the logarithm of an equation's power, from replica to replica
_OPEN = np.log(4.0)  # standard deviation of a damping's logarithm, before the power is looked at
_WIDEST = np.log(16.0)


def with_ringing_matched(setting: Setting, workers: Workers) -> Setting:
    """The setting whose replicas leave of the equations of fast hinges what the log leaves.

    setting   free of the regression's bias; one that is not simulated stays as it is
    """
    if not setting.simulates:
        return setting
    robot = setting.robot
    motions = [condition(log, robot).motion for log in setting.logs]
    names = ringing(robot, motions, setting.period)
    rows = [robot.coordinates.index(name.replace(".d[", ".eps[")) for name in names]
    if not names:
        return setting
    of_log = _power(setting, setting.logs)[rows]
    for _ in range(_ROUNDS):
        jobs = [workers.submit(_power_of_replica, _damped(setting, names, f)) for f in _FACTORS]
        try:
            louder = np.log([job.result()[rows] / of_log for job in jobs])
        except SimulationError:  # without damping a hinge may shake the whole arm
            return setting
        setting = _damped(setting, names, np.exp([_matching(each) for each in louder.T]))
    return setting


def _matching(louder: np.ndarray) -> float:
    """Logarithm of the factor of a damping; louder: those of a replica's power over the log's, per factor."""
    factors = np.linspace(-_WIDEST, _WIDEST, 201)
    missed = _between(factors, louder) / _SCATTER
    return float(factors[np.argmin(missed**2 + (factors / _OPEN) ** 2)])


def _between(factors: np.ndarray, louder: np.ndarray) -> np.ndarray:
    """Straight between the probes, and beyond them as at the nearest one."""
    return np.interp(factors, np.log(_FACTORS), louder)


def _damped(setting: Setting, names: Sequence[str], factors: float | np.ndarray) -> Setting:
    values = setting.robot.parameters
    own = np.array([values[name] for name in names]) * factors
    changed = dict(zip(names, own.tolist(), strict=True))
    return replace(
        setting,
        robot=setting.robot.with_parameters(changed),
        simulated=setting.simulated.with_parameters(changed),
    )


def _power_of_replica(fmu: Simulator, setting: Setting) -> np.ndarray:
    (logs,) = judged_replicas(fmu, setting, [_SEED])
    return _power(setting, logs)


def _power(setting: Setting, logs: Sequence[Log]) -> np.ndarray:
    """(n,) what the regression leaves of each equation, squared, in all of the band in which it is sound."""
    plan = replace(setting.robot.settings.processing, band=None)
    _, left = left_of(replace(setting, robot=setting.robot.with_settings(processing=plan)), logs)
    return np.sum([np.square(r).sum(axis=1) for r in left], axis=0)
