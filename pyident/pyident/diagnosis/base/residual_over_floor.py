"""A fitted model against its logs, and against replicas of itself that went through the same analysis."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flexmodels.robot import Robot
from pyident.diagnosis.base.balance import raised_beside
from pyident.diagnosis.base.candidates import Candidate, bounds, columns_of, every_law, needed_torque
from pyident.diagnosis.base.carried_loads import with_carried_loads
from pyident.diagnosis.base.projection import (
    Base,
    Columns,
    Gain,
    Limits,
    gains,
    gains_over,
    others_of,
    solve_base,
)
from pyident.diagnosis.base.replicas import replicated
from pyident.diagnosis.base.setting import Setting, together
from pyident.logs.log import Log
from pyident.regression.spectrum import Band, Equations, Floor, all_over, floors, levels_of, pooled
from pyident.rules.periodic import PeriodicRules
from pyident.simulation.denoised import denoised_equations
from pyident.simulation.simulator import Simulator, Workers

EDGES = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)  # Hz: bands in which the residual is watched

Progress = Callable[[float], None]
Listing = Callable[[Robot, Sequence[Equations], np.ndarray, PeriodicRules], list[Candidate]]
Named = Sequence[Candidate]


@dataclass(frozen=True)
class Region:
    """Some rows of the equations, in some bands of EDGES, by number."""

    rows: tuple[int, ...]
    bands: tuple[int, ...] = tuple(range(len(EDGES)))

    def meets(self, other: "Region") -> bool:
        """Whether they have a row and a band in common."""
        return not (set(self.rows).isdisjoint(other.rows) or set(self.bands).isdisjoint(other.bands))

    def inside(self, bands: Sequence[np.ndarray]) -> list[np.ndarray]:
        """`bands` (E, bands) per log, as of `bands_of`, without the others."""
        own = np.isin(np.arange(len(EDGES)), self.bands)
        return [log & own for log in bands]

    def within(self, bands: Sequence[np.ndarray]) -> list[tuple[np.ndarray, ...]]:
        """Per log the indices of its equations (n, E); bands as of `bands_of`."""
        rows = np.array(self.rows, int)
        return [np.ix_(rows, np.flatnonzero(log.any(axis=1))) for log in self.inside(bands)]


@dataclass(frozen=True)
class Examination:
    """Data and B replicas, analysed alike.

    floors              of each log
    candidates, columns, gains   what could be added, and what each would explain of the data's residual
    replica_gains       (B, C) the same of the replicas' residuals: the method's own trace
    replica_residuals   (B) per log (n, E)
    energy              (n, bands) mean square of the data's residual over the floor
    replica_energy      (B, n, bands) the same of the replicas' residuals
    raised              (n,) factor of each equation's floors, by what it lacks (see `raised_floors`)
    """

    setting: Setting
    floors: list[Floor]
    logs: list[Equations]
    base: Base
    candidates: list[Candidate]
    columns: list[Columns]
    gains: list[Gain]
    replica_gains: np.ndarray
    replica_residuals: list[list[np.ndarray]]
    energy: np.ndarray
    replica_energy: np.ndarray
    count: np.ndarray
    raised: np.ndarray

    def of_others(self, listed: Sequence[Candidate]) -> "Examination":
        """The same data and replicas with other candidates, all of them along the data's motion."""
        columns, limits = _columns_and_bounds(self.setting.robot, listed, self.logs, self.levels)
        explained = gains(self.base, columns, limits)
        pretended = _along_same_motion(self.base, columns, limits, self.replica_residuals)
        return replace(
            self, candidates=list(listed), columns=columns, gains=explained, replica_gains=pretended
        )

    @property
    def floor_energies(self) -> np.ndarray:
        """(n,) energy that replicas leave on each equation, on average."""
        return (self.replica_energy.mean(axis=0) * self.count).sum(axis=1)

    @property
    def used(self) -> np.ndarray:
        """(n,) whether any sample is of use on an equation."""
        return np.any([log.part.use.any(axis=0) for log in self.logs], axis=0)

    @cached_property
    def bands(self) -> list[np.ndarray]:
        """Per log (E, bands): 1 where an equation lies in a band."""
        return bands_of(self.logs)

    def beyond_floor(self, base: Base, rows: Sequence[int]) -> float:
        """Energy that a base leaves on some equations beyond what replicas leave, band by band."""
        return self.beyond_floor_in(base, Region(tuple(rows)))

    def beyond_floor_in(self, base: Base, region: Region) -> float:
        """The same in a region only."""
        return self.excess(base.residual, region.inside(self.bands), region.rows)[0]

    def excess(
        self, residuals: Sequence[np.ndarray], bands: Sequence[np.ndarray], rows: Sequence[int]
    ) -> tuple[float, float]:
        """Energy of residuals, per log (n, E), on some equations beyond what replicas leave; and that.

        Both are summed band by band, bands as of `bands_of`: a floor that is too high in one band, where it
        costs nothing, must not hide what is left in another. Bands that the examination has not do not count.
        """
        listed = list(rows)
        left = sum(np.square(r[listed]) @ inside for r, inside in zip(residuals, bands, strict=True))
        count = sum(inside.sum(axis=0) for inside in bands) * (self.count > 0)
        floor = self.replica_energy.mean(axis=0)[listed] * count
        beyond = np.maximum(left - floor, 0.0) * (self.count > 0)
        return float(beyond.sum()), float(floor.sum())

    @property
    def most_over_floor(self) -> np.ndarray:
        """(n,) the most that a replica leaves on each equation, over the average."""
        each = (self.replica_energy * self.count).sum(axis=2)
        return each.max(axis=0) / np.maximum(each.mean(axis=0), 1e-300)

    def by_band(self, residuals: Sequence[np.ndarray]) -> np.ndarray:
        """(logs, n, bands) energy of residuals, per log (n, E)."""
        return np.array([np.square(r) @ inside for r, inside in zip(residuals, self.bands, strict=True)])

    @cached_property
    def replicas_by_band(self) -> np.ndarray:
        """(B, logs, n, bands) the same of the replicas'."""
        return np.array([self.by_band(made) for made in self.replica_residuals])

    @cached_property
    def floor(self) -> Floor:
        """Of a log that is none of these."""
        return pooled(self.floors)

    @cached_property
    def levels(self) -> list[np.ndarray]:
        """Per log (n, E) floors of its equations."""
        return levels_of(self.floors, self.logs)


def examine(
    setting: Setting, workers: Workers, progress: Progress, listing: Listing = every_law, beside: Named = ()
) -> Examination:
    """Run the replicas and hold the data against them.

    workers   processes with the fitted robot's FMU
    listing   of the candidates to look at;  beside: which floors are raised
    """
    robot, logs, count = setting.robot, setting.logs, setting.rules.replicas.count
    jobs = [workers.submit(replicated, setting, group) for group in together(range(count))]
    replicas, bands, residuals = [], [], []
    for i, job in enumerate(jobs):
        for made, found, left in job.result():
            replicas.append(made)
            bands += found
            residuals += left
        progress(0.5 * (i + 1) / len(jobs))
    own_floors = floors(bands, residuals, len(logs))
    plain = whitened(robot, logs, own_floors)
    raised = raised_beside(robot, plain, levels_of(own_floors, plain), beside)
    data = [e.over(raised[:, None]) for e in plain]
    base = solve_base(data)
    own_floors = [Floor(f.frequencies, f.rms * raised[:, None]) for f in own_floors]
    levels = levels_of(own_floors, data)
    if not setting.simulates:
        chance = setting.rules.search.chance
        data = with_needed_torques(robot, data)
        robot = with_carried_loads(robot, data, base, levels, chance)
        setting = replace(setting, robot=robot)
    listed = listing(robot, data, base.p, setting.rules.periodic)
    noisy = np.array([setting.follows and not c.describes for c in listed], bool)
    own = [c for c, is_noisy in zip(listed, noisy, strict=True) if is_noisy]  # put to each replica's motion
    if setting.unfollowed:
        each = (residuals[at : at + len(logs)] for at in range(0, len(residuals), len(logs)))
        jobs = [workers.submit(_noise_beside, base, data, levels, left) for left in each]
    else:
        jobs = [workers.submit(_judged, robot, made, own_floors, own) for made in replicas]
    columns, limits = _columns_and_bounds(robot, listed, data, levels)
    explained = gains(base, columns, limits)
    judged = []
    for i, job in enumerate(jobs):
        judged.append(job.result())
        progress(0.5 + 0.5 * (i + 1) / count)
    left = [r for _, r, _ in judged]
    shared = np.flatnonzero(~noisy)
    of_shared = _along_same_motion(base, [columns[i] for i in shared], [limits[i] for i in shared], left)
    replica_gains = np.empty((count, len(listed)))
    replica_gains[:, noisy] = [g for g, _, _ in judged]
    replica_gains[:, shared] = of_shared
    mean_square, number = energy(data, base.residual)
    replica_energy = np.array([e for _, _, e in judged])
    found = explained, replica_gains, left, mean_square, replica_energy, number, raised
    return Examination(setting, own_floors, data, base, listed, columns, *found)


def _judged(
    _: Simulator, robot: Robot, logs: Sequence[Log], levels: Sequence[Floor], listed: Sequence[Candidate]
) -> tuple[list[float], list[np.ndarray], np.ndarray]:
    """Gains, residual and its energy in a replica."""
    data = whitened(robot, logs, levels)
    base = solve_base(data)
    explained = [g.energy for g in gains_of(robot, data, base, levels, listed)]
    return explained, base.residual, energy(data, base.residual)[0]


def _noise_beside(
    _: Simulator,
    base: Base,
    data: Sequence[Equations],
    levels: Sequence[np.ndarray],
    noise: Sequence[np.ndarray],
) -> tuple[list[float], list[np.ndarray], np.ndarray]:
    """As `_judged`, of noise in the logs' equations, (n, E) [N m], of which the base takes its part."""
    over = [r / level for r, level in zip(noise, levels, strict=True)]
    (along,) = others_of(base, [over]).along
    left = [r - basis @ along for r, basis in zip(over, base.basis, strict=True)]
    return [], left, energy(data, left)[0]


def _along_same_motion(
    base: Base,
    listed: Sequence[Columns],
    limits: Sequence[Limits],
    residuals: Sequence[Sequence[np.ndarray]],
) -> np.ndarray:
    """(B, C) gains in replicas that share the data's motion but for little, and so its columns."""
    if not listed:
        return np.zeros((len(residuals), 0))
    others = others_of(base, residuals)
    found = [gains_over(base, X, others, *ends) for X, ends in zip(listed, limits, strict=True)]
    return np.array(found).T


def _columns_and_bounds(
    robot: Robot, listed: Sequence[Candidate], data: Sequence[Equations], levels: Sequence[np.ndarray]
) -> tuple[list[Columns], list[Limits]]:
    """Of every candidate."""
    return list(columns_of(robot, listed, data, levels)), [bounds(robot, c) for c in listed]


def whitened(robot: Robot, logs: Sequence[Log], levels: Sequence[Floor]) -> list[Equations]:
    """The equations of logs, each over its floor."""
    found = denoised_equations(robot, logs)
    return all_over(found, levels_of(levels, found))


def with_needed_torques(robot: Robot, logs: Sequence[Equations]) -> list[Equations]:
    """The equations of logs whose motions tell the torques that a fitted robot needs.

    Bodies that belong to friction under load need others, which are not those of the logs.
    """
    parts = [log.part for log in logs]
    told = [replace(p, motion=replace(p.motion, needed=needed_torque(robot, p.motion))) for p in parts]
    return [replace(log, part=part) for log, part in zip(logs, told, strict=True)]


def gains_of(
    robot: Robot, data: Sequence[Equations], base: Base, levels: Sequence[Floor], listed: Sequence[Candidate]
) -> list[Gain]:
    """What each candidate would explain of the base's residual."""
    return gains(base, *_columns_and_bounds(robot, listed, data, levels_of(levels, data)))


def bands_of(logs: Sequence[Equations]) -> list[np.ndarray]:
    """Per log (E, bands): 1 where an equation lies in a band of EDGES."""
    return [_in_band(log.band)[:, None] == np.arange(len(EDGES)) for log in logs]


def _in_band(band: Band) -> np.ndarray:
    """(E,) number of the band of EDGES in which each equation lies."""
    return np.digitize(np.tile(band.frequencies, 2), EDGES) - 1


def energy(data: Sequence[Equations], left: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Mean square of a residual (n, E) per log: (n, bands); and the number of equations in each, (bands,)."""
    total, number = 0.0, 0.0
    for e, r in zip(data, left, strict=True):
        at = _in_band(e.band)
        total = total + np.array([np.square(r[:, at == b]).sum(axis=1) for b in range(len(EDGES))]).T
        number = number + np.array([np.sum(at == b) for b in range(len(EDGES))])
    return np.asarray(total) / np.maximum(number, 1), np.asarray(number)
