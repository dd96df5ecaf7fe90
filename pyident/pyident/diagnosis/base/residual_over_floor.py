"""A fitted model against its logs, and against replicas of itself that went through the same analysis."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate, bounds, candidates, columns, described
from pyident.diagnosis.base.discrepancy import inexact
from pyident.diagnosis.base.order_peaks import order_peaks
from pyident.diagnosis.base.projection import Base, Gain, gain, gains_over, others_of, solve_base
from pyident.diagnosis.base.setting import Setting, replica_of
from pyident.logs.log import Log
from pyident.regression.spectrum import Band, Equations, Floor, equations, floor
from pyident.simulation.simulator import Simulator, Workers

_BALANCING = 4  # rounds, after which weights change by less than a per cent
EDGES = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)  # Hz: bands in which the residual is watched

Progress = Callable[[float], None]


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

    def among(self, wanted: Callable[[Candidate], bool]) -> "Examination":
        """The same with some of the candidates only."""
        at = [i for i, c in enumerate(self.candidates) if wanted(c)]
        return replace(
            self,
            candidates=[self.candidates[i] for i in at],
            gains=[self.gains[i] for i in at],
            replica_gains=self.replica_gains[:, at],
        )

    @property
    def floor_energies(self) -> np.ndarray:
        """(n,) energy that replicas leave on each equation, on average."""
        return (self.replica_energy.mean(axis=0) * self.count).sum(axis=1)

    @property
    def most_over_floor(self) -> np.ndarray:
        """(n,) the most that a replica leaves on each equation, over the average."""
        each = (self.replica_energy * self.count).sum(axis=2)
        return each.max(axis=0) / np.maximum(each.mean(axis=0), 1e-300)

    @property
    def levels(self) -> list[np.ndarray]:
        return [self.floor.at(log.band) for log in self.logs]


def examine(
    setting: Setting, workers: Workers, progress: Progress, listed: Sequence[Candidate] | None = None
) -> Examination:
    """Run the replicas and hold the data against them.

    workers   processes with the fitted robot's FMU
    listed    the candidates to look at; None: all
    """
    robot, logs, count = setting.robot, setting.logs, setting.rules.replicas.count
    jobs = [workers.submit(replicated, setting, seed) for seed in range(count)]
    replicas, bands, residuals = [], [], []
    for i, job in enumerate(jobs):
        made, found, left = job.result()
        replicas.append(made)
        bands += found
        residuals += left
        progress(0.5 * (i + 1) / count)
    level = floor(bands, residuals)
    level, data, base = balanced(level, whitened(robot, logs, level))
    if listed is None:
        orders = order_peaks(robot, data, base.p, setting.rules.periodic)
        listed = [*candidates(robot, data, orders), *described(robot)]
    gains = gains_of(robot, data, base, level, listed)
    noisy = [setting.simulates and not c.describes for c in listed]
    own = [c for c, is_noisy in zip(listed, noisy, strict=True) if is_noisy]  # put to each replica's motion
    jobs = [workers.submit(_judged, robot, made, level, own) for made in replicas]
    judged = []
    for i, job in enumerate(jobs):
        judged.append(job.result())
        progress(0.5 + 0.5 * (i + 1) / count)
    shared = [c for c, is_noisy in zip(listed, noisy, strict=True) if not is_noisy]
    of_shared = _along_same_motion(robot, data, base, level, shared, [left for _, left, _ in judged])
    replica_gains = np.empty((count, len(listed)))
    replica_gains[:, noisy] = [g for g, _, _ in judged]
    replica_gains[:, np.logical_not(noisy)] = of_shared
    mean_square, number = energy(data, base)
    return Examination(
        setting,
        level,
        data,
        base,
        list(listed),
        gains,
        replica_gains,
        mean_square,
        np.array([e for _, _, e in judged]),
        number,
    )


def balanced(level: Floor, data: Sequence[Equations]) -> tuple[Floor, list[Equations], Base]:
    """Floor, equations and their base with no equation heavier than what it leaves allows.

    An equation that lacks something would else bend the parameters of all others to its own ends.
    """
    ratio = np.ones(len(level.rms))
    whitened_data = list(data)
    base = solve_base(whitened_data)
    for _ in range(_BALANCING):
        count = sum(r.shape[1] for r in base.residual)
        left = np.sqrt(sum(np.square(r).sum(axis=1) for r in base.residual) / count)
        scale = np.maximum(ratio * left, 1.0) / ratio
        ratio = ratio * scale
        whitened_data = [e.over(np.repeat(scale[:, None], e.y.shape[1], axis=1)) for e in whitened_data]
        base = solve_base(whitened_data)
    return Floor(level.frequencies, level.rms * ratio[:, None]), whitened_data, base


def replicated(fmu: Simulator, setting: Setting, seed: int) -> tuple[list[Log], list[Band], list[np.ndarray]]:
    """Logs of one replica, their bands and the residuals that the regression leaves."""
    made = judged_replica(fmu, setting, seed)
    logs = _equations(setting.robot, made)
    level = 1 / np.maximum(setting.solution.weights, 1e-300)
    base = solve_base([e.over(np.repeat(level[:, None], e.y.shape[1], axis=1)) for e in logs])
    return made, [e.band for e in logs], [r * level[:, None] for r in base.residual]


def judged_replica(fmu: Simulator, setting: Setting, seed: int) -> list[Log]:
    """Logs as the setting's robot would have made them, with what no model is exact to."""
    share = setting.rules.replicas.inexact
    made = replica_of(fmu, setting, setting.repeats, seed)
    return [inexact(setting.robot, log, share, len(made) * seed + i) for i, log in enumerate(made)]


def _judged(
    _: Simulator, robot: Robot, logs: Sequence[Log], level: Floor, listed: Sequence[Candidate]
) -> tuple[list[float], list[np.ndarray], np.ndarray]:
    """Gains, residual and its energy in a replica."""
    data = whitened(robot, logs, level)
    base = solve_base(data)
    gains = [g.energy for g in gains_of(robot, data, base, level, listed)]
    return gains, base.residual, energy(data, base)[0]


def _along_same_motion(
    robot: Robot,
    data: Sequence[Equations],
    base: Base,
    level: Floor,
    listed: Sequence[Candidate],
    residuals: Sequence[Sequence[np.ndarray]],
) -> np.ndarray:
    """(B, C) gains in replicas that share the data's motion but for little, and so its columns."""
    levels, others = [level.at(e.band) for e in data], others_of(base, residuals)
    found = [gains_over(base, columns(robot, c, data, levels), others, *bounds(robot, c)) for c in listed]
    return np.array(found).reshape(len(listed), len(residuals)).T


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
