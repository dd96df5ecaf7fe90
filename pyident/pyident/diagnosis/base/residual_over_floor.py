"""A fitted model against its logs, and against replicas of itself that went through the same analysis."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate, bounds, candidates, columns
from pyident.diagnosis.base.projection import Base, Gain, gain, solve_base
from pyident.estimation.identify import identified
from pyident.estimation.least_squares import Reduced, Solution, reduce, solve, solve_weighted
from pyident.logs.log import Log
from pyident.refinement.remove_bias import seen
from pyident.regression.equations import Problem
from pyident.regression.spectrum import Band, Equations, Floor, equations, floor
from pyident.simulation.replica import Repeat, repeats
from pyident.simulation.sensor_noise import sensor_noise

REPLICAS = 20
PROBES = 4  # replicas that show the bias of the fit ...
SMALL_STEP = 1e-4  # s
ROUNDS = 3  # ... and times that it is taken away
EDGES = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)  # Hz: bands in which the residual is watched

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Setting:
    """What data and replicas share: the fitted robot, how each log is repeated, the sensors' noise.

    solver   the FMU's own parameters for the replicas
    """

    robot: Robot
    simulated: Robot
    repeats: tuple[Repeat, ...]
    noise: dict[str, float]
    reduced: Reduced
    solution: Solution
    solver: Mapping[str, float] = field(default_factory=dict)

    @property
    def logs(self) -> list[Log]:
        return [r.log for r in self.repeats]


@dataclass(frozen=True)
class Examination:
    """Data and B replicas, analysed alike.

    candidates, gains   what could be added and what each would explain of the data's residual
    replica_gains       (B, C) the same of the replicas' residuals: the method's own trace
    energy              (n, bands) mean square of the data's residual over the floor
    replica_energy      (B, n, bands) the same of the replicas' residuals
    """

    setting: Setting
    floor: Floor
    logs: list[Equations]
    base: Base
    candidates: list[Candidate]
    gains: list[Gain]
    replica_gains: np.ndarray
    energy: np.ndarray
    replica_energy: np.ndarray
    count: np.ndarray

    @property
    def floor_energies(self) -> np.ndarray:
        """(n,) energy that replicas leave on each equation, on average."""
        return (self.replica_energy.mean(axis=0) * self.count).sum(axis=1)

    @property
    def levels(self) -> list[np.ndarray]:
        return [self.floor.at(log.band) for log in self.logs]


def set_up(robot: Robot, logs: Sequence[Log]) -> Setting:
    """Fit the robot to the logs and prepare its replicas. Raises LogError."""
    problem = Problem(robot, tuple(condition(log, robot) for log in logs))
    reduced = reduce(problem.blocks(), problem.rows, problem.columns)
    solution = solve_weighted(reduced)
    fitted = identified(robot, reduced, solution).robot
    noise = sensor_noise(fitted, logs, solution.p)
    simulated, made_again = repeats(fitted, logs)
    return Setting(fitted, simulated, made_again, noise, reduced, solution)


def unbiased(setting: Setting, workers: Any, rounds: int = ROUNDS, probes: int = PROBES) -> Setting:
    """The setting with the parameters whose replicas the regression finds where it found the data.

    Noise and sampling bias a regression; replicas of what it found show by how much, as in
    `refinement.remove_bias`.
    """
    found = setting.solution.p
    for number in range(rounds):
        seeds = range(-1 - number * probes, -1 - (number + 1) * probes, -1)
        jobs = [workers.submit(_refitted, setting, seed) for seed in seeds]
        put_in = np.array(list(setting.robot.linear_parameters.values()))
        change = seen(setting.solution, found - np.mean([job.result() for job in jobs], axis=0))
        solution = replace(setting.solution, p=put_in + change)
        robot = identified(setting.robot, setting.reduced, solution).robot
        simulated = setting.simulated.with_parameters(robot.parameters)
        setting = replace(setting, robot=robot, simulated=simulated)
    return setting


def steadied(setting: Setting) -> Setting:
    """The setting for a fit that cannot be simulated as it is: with small steps and no hinge without damping.

    What a model lacks may bend its fit that far. Damping is taken as at least proportional to the stiffness,
    with the ratio that the hinges have in the middle.
    """
    values = setting.robot.parameters
    pairs = {d: d.replace(".d[", ".k[") for d in values if ".d[" in d}
    ratio = float(np.median([values[d] / values[k] for d, k in pairs.items() if values[k] > 0] or [0.0]))
    damped = {d: max(values[d], ratio * values[k]) for d, k in pairs.items()}
    return replace(
        setting,
        robot=setting.robot.with_parameters(damped),
        simulated=setting.simulated.with_parameters(damped),
        solver={"solver.step": SMALL_STEP},
    )


def examine(setting: Setting, workers: Any, progress: Progress, count: int = REPLICAS) -> Examination:
    """Run the replicas and hold the data against them. workers: processes with the fitted robot's FMU."""
    robot, logs = setting.robot, setting.logs
    jobs = [workers.submit(replicated, setting, seed) for seed in range(count)]
    replicas, bands, residuals = [], [], []
    for i, job in enumerate(jobs):
        made, found, left = job.result()
        replicas.append(made)
        bands += found
        residuals += left
        progress(0.5 * (i + 1) / count)
    level = floor(bands, residuals)
    data = whitened(robot, logs, level)
    listed = candidates(robot, data)
    jobs = [workers.submit(_judged, robot, made, level, listed) for made in replicas]
    base = solve_base(data)
    gains = gains_of(robot, data, base, level, listed)
    judged = []
    for i, job in enumerate(jobs):
        judged.append(job.result())
        progress(0.5 + 0.5 * (i + 1) / count)
    mean_square, number = energy(data, base)
    return Examination(
        setting,
        level,
        data,
        base,
        listed,
        gains,
        np.array([g for g, _ in judged]),
        mean_square,
        np.array([e for _, e in judged]),
        number,
    )


def replica_of(fmu: Any, setting: Setting, repeats: Sequence[Repeat], seed: int) -> list[Log]:
    """Logs as the setting's robot would have made them."""
    rng = np.random.default_rng(np.abs([seed, int(seed < 0)]))
    seeds = rng.integers(2**31, size=len(repeats))
    parameters = setting.robot.parameters | dict(setting.solver)
    return [
        r.replica(fmu.simulate, parameters, setting.noise, int(s))
        for r, s in zip(repeats, seeds, strict=True)
    ]


def _refitted(fmu: Any, setting: Setting, seed: int) -> np.ndarray:
    """What the regression finds in a replica."""
    robot = setting.robot
    problem = Problem(
        robot, tuple(condition(log, robot) for log in replica_of(fmu, setting, setting.repeats, seed))
    )
    return solve(reduce(problem.blocks(), problem.rows, problem.columns), setting.solution.weights).p


def replicated(fmu: Any, setting: Setting, seed: int) -> tuple[list[Log], list[Band], list[np.ndarray]]:
    """Logs of one replica, their bands and the residuals that the regression leaves."""
    made = replica_of(fmu, setting, setting.repeats, seed)
    logs = _equations(setting.robot, made)
    level = 1 / np.maximum(setting.solution.weights, 1e-300)
    base = solve_base([e.over(np.repeat(level[:, None], e.y.shape[1], axis=1)) for e in logs])
    return made, [e.band for e in logs], [r * level[:, None] for r in base.residual]


def _judged(_: Any, robot: Robot, logs: Sequence[Log], level: Floor, listed: Sequence[Candidate]):
    data = whitened(robot, logs, level)
    base = solve_base(data)
    return [g.energy for g in gains_of(robot, data, base, level, listed)], energy(data, base)[0]


def _equations(robot: Robot, logs: Sequence[Log]) -> list[Equations]:
    return equations(robot, [condition(log, robot) for log in logs], [log.period for log in logs])


def whitened(robot: Robot, logs: Sequence[Log], level: Floor) -> list[Equations]:
    """The equations of logs over the floor."""
    return [e.over(level.at(e.band)) for e in _equations(robot, logs)]


def gains_of(
    robot: Robot, data: Sequence[Equations], base: Base, level: Floor, listed: Sequence[Candidate]
) -> list[Gain]:
    """What each candidate would explain of the base's residual."""
    levels = [level.at(e.band) for e in data]
    return [gain(base, columns(robot, c, data, levels), *bounds(robot, c)) for c in listed]


def energy(data: Sequence[Equations], base: Base) -> tuple[np.ndarray, np.ndarray]:
    """Mean square of the residual, (n, bands), and the number of equations in each band, (bands,)."""
    total, number = 0.0, 0.0
    for e, r in zip(data, base.residual, strict=True):
        at = np.digitize(np.tile(e.band.frequencies, 2), EDGES) - 1
        total = total + np.array([np.square(r[:, at == b]).sum(axis=1) for b in range(len(EDGES))]).T
        number = number + np.array([np.sum(at == b) for b in range(len(EDGES))])
    return np.asarray(total) / np.maximum(number, 1), np.asarray(number)
