"""A log's equations, and the same of a simulation of it: what the instrumental estimate is made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from flexmodels.coordinate import of_joint
from flexmodels.cores import cores
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.fading import fading
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import Logs, Rows, acting
from pyident.estimation.physical import lower_bounds
from pyident.logs.log import Log
from pyident.refinement.instruments.missed import NotFollowedError, astray
from pyident.refinement.instruments.stand_in import driven
from pyident.regression.equations import Problem, centre, free_means
from pyident.regression.reduced import Reduced
from pyident.regression.regressor import predicted
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Look, Simulator, Workers

_STEP, _SMALL_STEP = "solver.step", 1e-4  # s
_DAMPED = 0.5  # of the damping per stiffness that the hinges have in the middle: the least simulated


@dataclass(frozen=True)
class Data:
    """A log's equations in memory, everything in use: A (N, n, P), y (N, n), use (N, n)."""

    part: Conditioned
    A: np.ndarray
    y: np.ndarray
    use: np.ndarray

    @cached_property
    def columns(self) -> list[np.ndarray]:
        """Per equation those of A that are not zero."""
        return acting(self.A)


@dataclass(frozen=True)
class Repeated:
    """A robot's logs, each with its equations and with what simulates it again."""

    robot: Robot
    data: list[Data]
    again: Sequence[Repeat]
    reduced: Reduced


def in_memory(robot: Robot, part: Conditioned) -> Data:
    """All equations of a log at once, without a free constant of those in use.

    In memory the samples of an entry are neighbours.
    """
    problem = Problem(robot, (replace(part, use=np.ones_like(part.use), free=()),))
    use = part.use[:: part.thinning]
    N, n = use.shape
    A, y = np.empty((n, len(problem.columns), N)).transpose(2, 0, 1), np.empty((N, n))
    at = 0
    for block, target in problem.blocks():
        A[at : at + len(target)], y[at : at + len(target)] = block, target
        at += len(target)
    centre(A, y, free_means(part, [(A, y, use)]))
    return Data(part, A, y, use)


def simulated_equations(robot: Robot, frame: pd.DataFrame, free: tuple[int, ...]) -> Data:
    """Those of a simulation; free: equations of its log whose torque is known but for a constant."""
    return in_memory(robot, replace(condition(Log(frame, "simulation"), robot), free=free))


def simulations(
    again: Sequence[Repeat], workers: Workers, parameters: Mapping[str, float]
) -> tuple[dict[str, float], list[pd.DataFrame]]:
    """The parameters, with a small step of the solver where one is needed, and each log's motion under them.

    A core for each log, or logs side by side. Raises SimulationError, NotFollowedError.
    """
    size = 1 if len(again) <= cores() else len(again)
    parts = [again[at : at + size] for at in range(0, len(again), size)]
    done = [job.result() for job in [workers.submit(_following, part, parameters) for part in parts]]
    steps = {name: value for used, _ in done for name, value in used.items() if name == _STEP}
    return {**parameters, **steps}, [frame for _, frames in done for frame in frames]


def _following(
    fmu: Simulator, again: Sequence[Repeat], parameters: Mapping[str, float]
) -> tuple[Mapping[str, float], list[pd.DataFrame]]:
    look, small = astray(again), {**parameters, _STEP: _SMALL_STEP}
    try:
        return parameters, _side_by_side(fmu, again, [parameters], look)[0]
    except (SimulationError, NotFollowedError):  # what a poor start makes of a small inertia may vibrate fast
        return small, _side_by_side(fmu, again, [small], look)[0]


def simulated(
    fmu: Simulator, again: Sequence[Repeat], sets: Sequence[Mapping[str, float]]
) -> list[list[pd.DataFrame]]:
    """Each log's motion made by the model, for every set of parameters. Raises SimulationError."""
    try:
        return _side_by_side(fmu, again, sets)
    except SimulationError:
        if all(_STEP in parameters for parameters in sets):
            raise
        alone = [{**parameters, _STEP: _SMALL_STEP} for parameters in sets]
        return [_side_by_side(fmu, again, [parameters])[0] for parameters in alone]


def _side_by_side(
    fmu: Simulator, again: Sequence[Repeat], sets: Sequence[Mapping[str, float]], look: Look | None = None
) -> list[list[pd.DataFrame]]:
    plans = [repeat.plan for _ in sets for repeat in again]
    frames = iter(fmu.simulate_batch(plans, [parameters for parameters in sets for _ in again], look=look))
    return [[repeat.cut(next(frames)) for repeat in again] for _ in sets]


def rows_of(robot: Robot, data: Data, frame: pd.DataFrame, p: np.ndarray) -> Rows:
    """Instruments from a simulation, the log's torques without what its equations leave under p (P,)."""
    made = simulated_equations(robot, frame, data.part.free)
    share = faded(robot, data.use * made.use)
    left = made.y - predicted(made.A, p) if driven(robot) else 0.0
    return Rows(data.A, made.A, data.y - left, share)


def faded(robot: Robot, use: np.ndarray) -> np.ndarray:
    """(N, n) how much each equation counts."""
    return fading(use) if robot.settings.processing.decimate == 1 else use


def every(rows: list[Rows]) -> Logs:
    """The logs' equations as the solver asks for them."""
    return lambda: rows


def lightest_rotors(robot: Robot) -> dict[str, float]:
    """Motor inertia [kg m2] -> the least behind a flexible hinge that a sampled controller can hold.

    A controller that damps by Kd from differences over its period T holds no free rotor below some Kd T; the
    robot of a log was held.
    """
    control = robot.controller
    if control is None:
        return {}
    gains = zip(robot.numbered, control.Kd, strict=True)
    return {
        of_joint(k, "J_m"): Kd * control.period
        for (k, joint), Kd in gains
        if joint.flexible and of_joint(k, "J_m") in robot.linear_parameters
    }


def simulable(
    robot: Robot, names: tuple[str, ...], values: np.ndarray, hinges: Mapping[str, float] | None = None
) -> np.ndarray:
    """Values (P,) under which a simulation is quiet: noise may leave no small damping, friction or rotor.

    A hinge that rings would fill the sums with what happens between the samples, and a rotor too light for
    its controller runs away.
    hinges   stiffnesses and dampings that take the place of values
    """
    given = dict(zip(names, values.tolist(), strict=True)) | dict(hinges or {})
    pairs = {d: d.replace(".d[", ".k[") for d in given if ".d[" in d}
    ratio = float(np.median([given[d] / given[k] for d, k in pairs.items() if given[k] > 0] or [0.0]))
    least = (
        lower_bounds(robot)
        | lightest_rotors(robot)
        | {d: _DAMPED * ratio * given[k] for d, k in pairs.items()}
    )
    return np.array([max(v, least.get(name, -np.inf)) for name, v in given.items()])
