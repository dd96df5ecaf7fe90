"""A model on trial: what its equations leave of logs, what its simulation misses, both on replicas too.

Each is judged twice: under the model's own parameters, which tells how good the model is, and under those
that the regression finds in that log or replica, which tells how good its structure is. A replica's errors
are the floor, what the method itself leaves where the model is right; its own parameters are the model's
with the scatter of the fits among replicas.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
import pandas as pd

from flexmodels.robot import Robot
from pyident.comparison.trial import TIP, Trial, again
from pyident.conditioning.samples import Conditioned
from pyident.estimation.least_squares import Solution
from pyident.estimation.physical import consistent
from pyident.logs.log import Log
from pyident.refinement.remove_bias import seen
from pyident.regression.equations import Problem
from pyident.regression.loads.bodies import carried_loads
from pyident.regression.reduced import Reduced
from pyident.regression.regressor import residual_of
from pyident.simulation import replica
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Simulator, Workers

R = TypeVar("R")
Progress = Callable[[float], None]
_TOGETHER = 3  # replicas that one process simulates at once: as many as fill the cores of a small machine


@dataclass(frozen=True)
class Part:
    """What is left of one log, N samples.

    part       the conditioned log
    residual   (N, n) of the equations, 0 where they are not used
    refitted   (N, n) the same under what the regression finds
    time, missed   (S,) [s] and signal -> (S,), log less simulation
    loads      (N, joints) as of `loads_of`
    counted    signal -> (S,) where what is missed counts; none: everywhere
    """

    part: Conditioned
    period: float
    residual: np.ndarray
    refitted: np.ndarray
    time: np.ndarray
    missed: dict[str, np.ndarray]
    loads: np.ndarray
    counted: dict[str, np.ndarray] = field(default_factory=dict)

    def missed_where_counted(self, name: str) -> np.ndarray:
        """(S or fewer,) of one signal."""
        return self.missed[name][self.counted[name]] if name in self.counted else self.missed[name]


@dataclass(frozen=True)
class Refit:
    """The judged logs, or a replica of them, and what the regression finds in the fitted ones."""

    judged: list[Log]
    reduced: Reduced
    solution: Solution

    def robot(self, like: Robot, p: np.ndarray) -> Robot:
        """The robot with the physically consistent parameters nearest to p (P,)."""
        p = consistent(like, self.reduced, replace(self.solution, p=p))
        return like.with_parameters(dict(zip(self.reduced.columns, p, strict=True)))


def run_trial(
    trial: Trial, workers: Workers, progress: Progress, replicas: int
) -> tuple[list[Part], list[list[Part]]]:
    """What the model leaves of the judged logs, and of each of their replicas.

    workers   processes that hold the FMU of `trial.simulated`
    """
    data = judged_logs(trial, workers)
    trial = _with_tip_noise(trial, data)
    told = _Told(progress, 2 * replicas + 1, 1)
    groups = [own.tolist() for own in np.array_split(range(replicas), -(-replicas // _TOGETHER))]
    refits = told.all_of([workers.submit(_refits, trial, seeds) for seeds in groups])
    middle = np.mean([f.solution.p for f in refits], axis=0)
    widen = np.sqrt(replicas / (replicas - 1))  # the middle is one of their own
    scatters = [widen * (f.solution.p - middle) for f in refits]
    own = [([refits[i] for i in seeds], [scatters[i] for i in seeds]) for seeds in groups]
    return data, told.all_of([workers.submit(_of_replicas, trial, *group) for group in own])


def judged_logs(trial: Trial, workers: Workers) -> list[Part]:
    """What the model leaves of the judged logs, without a floor beside it."""
    return workers.submit(_of_logs, trial).result()


@dataclass
class _Told:
    """Progress of work of so many steps, of which some are done."""

    progress: Progress
    steps: int
    done: int

    def all_of(self, jobs: "Sequence[Future[list[R]]]") -> list[R]:
        """The results of all jobs one after the other."""
        out: list[R] = []
        for job in jobs:
            found = job.result()
            self.done += len(found)
            self.progress(self.done / self.steps)
            out += found
        return out


def _of_logs(fmu: Simulator, trial: Trial) -> list[Part]:
    found = _fit(trial, [r.log for r in trial.fitted], [r.log for r in trial.judged])
    return _judged(fmu, trial, [trial.robot], [found])[0]


def _refits(fmu: Simulator, trial: Trial, seeds: Sequence[int]) -> list[Refit]:
    """Of a replica per seed."""
    chance = [np.random.default_rng(seed) for seed in seeds]
    drawn = [[int(rng.integers(2**31)) for _ in trial.repeats] for rng in chance]
    found = []
    for logs in again(fmu, trial, drawn):
        made = {id(r): log for r, log in zip(trial.repeats, logs, strict=True)}
        found.append(_fit(trial, [made[id(r)] for r in trial.fitted], [made[id(r)] for r in trial.judged]))
    return found


def _of_replicas(
    fmu: Simulator, trial: Trial, refits: Sequence[Refit], scatters: Sequence[np.ndarray]
) -> list[list[Part]]:
    """scatters (P,) each: of the fit among those of all replicas."""
    own = np.array(list(trial.robot.linear_parameters.values()))
    robots = [
        refit.robot(trial.robot, own + seen(refit.solution, scatter))
        for refit, scatter in zip(refits, scatters, strict=True)
    ]
    return _judged(fmu, trial, robots, refits)


def _fit(trial: Trial, fitted: Sequence[Log], judged: list[Log]) -> Refit:
    found = trial.estimator(
        Problem(trial.robot, tuple(trial.conditioned(log, trial.robot) for log in fitted))
    )
    return Refit(judged, found.reduced, found.solution)


def _with_tip_noise(trial: Trial, parts: Sequence[Part]) -> Trial:
    """The trial that knows the noise of the tip's sensor, from where the simulations cannot follow it."""
    found: dict[str, list[float]] = {}
    for r, left in zip(trial.judged, parts, strict=True):
        seen = tuple(name for name in TIP if name in left.missed)
        simulated = r.log.frame.iloc[-len(left.time) :].reset_index(drop=True).copy()
        cut = replace(r, log=Log(simulated.copy(), r.log.source))
        for name in seen:
            simulated[name] = simulated[name] - left.missed[name]
        for name, sigma in replica.sensor_noise(cut, simulated, seen).items():
            found.setdefault(name, []).append(sigma)
    return replace(trial, noise=trial.noise | {name: float(np.mean(s)) for name, s in found.items()})


def _judged(
    fmu: Simulator, trial: Trial, robots: Sequence[Robot], refits: Sequence[Refit]
) -> list[list[Part]]:
    """What each robot leaves of the logs that were fitted anew."""
    plans = [r.plan for _ in robots for r in trial.judged]
    frames = iter(fmu.simulate_batch(plans, [robot.parameters for robot in robots for _ in trial.judged]))
    found = []
    for robot, refit in zip(robots, refits, strict=True):
        fitted = refit.robot(robot, refit.solution.p)
        each = zip(refit.judged, trial.judged, trial.since, strict=True)
        found.append([_part(trial, (robot, fitted), log, r, next(frames), s) for log, r, s in each])
    return found


def _part(
    trial: Trial, robots: tuple[Robot, Robot], log: Log, r: Repeat, simulated: pd.DataFrame, since: float
) -> Part:
    """robots: the one that is judged, and this with what the regression finds.

    simulated   the plan of `r` by the first
    """
    robot, fitted = robots
    frame = r.cut(simulated)
    time = frame["time"].to_numpy()
    late = time >= since
    names = [*robot.coordinates, *robot.torques, *TIP]
    missed = {
        name: (log.frame[name] - frame[name]).to_numpy()[late]
        for name in names
        if name in log.frame and name in frame and name in r.log.frame
    }
    missed |= {n: missed[n] - missed[n].mean() for n in log.up_to_constant if n in missed}
    used = replace(log, frame=log.frame.iloc[np.flatnonzero(late)].reset_index(drop=True))
    part = trial.conditioned(used, robot)
    left = residual(robot, part), residual(fitted, part)
    counted = _counted(trial.robot, part, time[late] - used.began) if trial.paths else {}
    return Part(part, log.period, *left, time[late], missed, loads_of(trial.robot, part), counted)


def _counted(robot: Robot, part: Conditioned, time: np.ndarray) -> dict[str, np.ndarray]:
    """Torque -> (S,) whether its equation is used at a time [s].

    Elsewhere its joint rests or turns round. There the simulation of a drawn motion, whose friction lags
    behind that of the measured motion, misses twice the friction, and one of the log does not.
    """
    assert part.motion.time is not None
    at = np.searchsorted(part.motion.time, time - 1e-9)
    inside = at < len(part.use)
    use = part.use[np.minimum(at, len(part.use) - 1)] > 0
    found = {name: inside & use[:, k] for k, name in enumerate(robot.torques)}
    return {name: counts for name, counts in found.items() if counts.any()}


def loads_of(robot: Robot, part: Conditioned) -> np.ndarray:
    """(N, joints) what the robot's bodies ask of its motors; zero where every joint shows it by its twist."""
    if all(joint.flexible for joint in robot.joints):
        return np.zeros((len(part.target), len(robot.joints)))
    return carried_loads(robot, part.motion)


def residual(robot: Robot, part: Conditioned) -> np.ndarray:
    """(N, n): torque less Φ p, not thinned, 0 where an equation is not used."""
    p = np.array(list(robot.linear_parameters.values()))
    return residual_of(robot, part, p)
