"""Laws of a hinge that rings faster than the log is sampled, judged by the trace that they leave.

Along such a log a law cannot be evaluated: what it does between the samples is not there. Its trace can be
made. The model with the law is fitted, its bias removed; it is simulated over the log's motion, and the
result is analysed as if the law were not known. What that leaves over is the law's signature. Nothing is
scaled to make it fit: the signature of what is missing has the energy of the data's own residual, equation by
equation and band by band, and its course more than that of any other law. Not all of its course: the ringing
itself starts from noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from flexmodels.coordinate import joint_number
from flexmodels.inputs import SimulationError
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.diagnosis.base.candidates import Candidate, law_of, with_law
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.base.residual_over_floor import energy, whitened
from pyident.diagnosis.base.setting import Setting, replicas_of, set_up, unbiased
from pyident.diagnosis.search.search import Search
from pyident.logs.log import Log, LogError
from pyident.regression.spectrum import Floor
from pyident.simulation.replica import Repeat, repeat_like
from pyident.simulation.simulator import OpenPool, Simulator

_REPLICAS = 4  # of which a signature is the mean
_ROUNDS, _PROBES = 4, 2  # of the removal of the bias
_TRIALS = 6  # of the nonlinear parameter of the best law
_RANGE = 2.5  # times and parts of what the regression found for it

Residuals = list[np.ndarray]  # per log (n, E), over the floor


@dataclass(frozen=True)
class Trace:
    """A law, the robot that has it, and what its signature is of the data's residual.

    followed    share of the energy above the floor that is gone when the signature is subtracted
    explained   share of it that the signature has, too, in every equation and band
    heldout     fall of the residual's energy in logs that were not used, None: there are none
    """

    candidate: Candidate
    setting: Setting
    followed: float
    explained: float
    heldout: float | None

    @property
    def holds(self) -> bool:
        """Whether it says anything at all."""
        rules = self.setting.rules.search
        shown = self.explained >= rules.trace_explained and self.followed >= rules.trace_followed
        return shown and (self.heldout is None or self.heldout > 0)


def traces(search: Search, heldout: Sequence[Log], open_pool: OpenPool) -> list[Trace]:
    """The laws whose signature is the data's residual, best first; empty when there is none.

    Only where a deformation's equation exceeds its floor most: a motor's laws can be evaluated. Raises
    LogError.
    """
    search = search.resting_on(())
    judge = _Judge(search, heldout, open_pool)
    found = [judge.trace(c) for c in _suspects(search)]
    ranked = sorted((t for t in found if t is not None), key=lambda t: -t.followed)
    if ranked:
        ranked[0] = judge.refined(ranked[0])
    return [t for t in ranked if t.holds and t.followed >= search.rules.tie * ranked[0].followed]


def _suspects(search: Search) -> list[Candidate]:
    """Laws on the equation with the largest excess that explain more of it than replicas pretend."""
    ex = search.examination
    row = int(np.argmax(sum(np.square(r).sum(axis=1) for r in ex.base.residual) - ex.floor_energies))
    if row < len(search.robot.joints):
        return []
    joint = joint_number(search.robot.coordinates[row])
    best = {c.family: c for c in ex.candidates if c.joint == joint and c.log is None}
    listed = [search.best(c.effect, c.joint) for c in best.values()]
    return [
        f.candidate
        for f in listed
        if f is not None and row in search.rows(f.candidate) and search.p_value(f) <= search.rules.level
    ]


class _Judge:
    """Holds signatures against the data's residual."""

    def __init__(self, search: Search, heldout: Sequence[Log], open_pool: OpenPool):
        self.search, self.open_pool = search, open_pool
        ex = search.examination
        self.setting, self.floors, self.heldout = ex.setting, (ex.floors, ex.floor), tuple(heldout)
        self.data = ex.base.residual
        self.other = _elsewhere(self.setting.robot, self.heldout, ex.floor, ex.base.p)

    def trace(self, candidate: Candidate) -> Trace | None:
        """None where the model with the law cannot be simulated, or no bodies that can exist go with it."""
        try:
            setting = set_up(with_law(self.setting.simulated, candidate), self.setting.logs)
            others = tuple(repeat_like(setting.simulated, setting.robot, log) for log in self.heldout)
            with self.open_pool(setting.simulated) as workers:
                setting = unbiased(setting, workers, _ROUNDS, _PROBES)
                arguments = setting, self.setting.robot, self.floors, others
                job = workers.submit(_signatures, *arguments, range(_REPLICAS))
                own, other, energies = zip(*job.result(), strict=True)
        except (SimulationError, LogError):  # the logs themselves were fitted before
            return None
        heldout = 1 - _distance(self.other, other) / _distance(self.other) if others else None
        return Trace(candidate, setting, self._followed(own), self._explained(energies), heldout)

    def refined(self, best: Trace) -> Trace:
        """With its nonlinear parameter, if it has one, where the signature fits best."""
        if len(best.candidate.values) != 1:
            return best
        (name, middle), seen = best.candidate.values[0], [best]

        def missed(exponent: float) -> float:
            trace = self.trace(best.candidate.at({name: middle * float(np.exp(exponent))}))
            seen.extend([trace] if trace else [])
            return -trace.followed if trace else 0.0

        reach = float(np.log(_RANGE))
        minimize_scalar(missed, bounds=(-reach, reach), method="bounded", options={"maxiter": _TRIALS})
        return max(seen, key=lambda t: t.followed)

    def _followed(self, signatures: Sequence[Residuals]) -> float:
        """Both residuals have a noise of one floor."""
        noise = self.search.floor_energy * (1 + 1 / len(signatures))
        return 1 - (_distance(self.data, signatures) - noise) / max(self.search.excess, 1e-300)

    def _explained(self, energies: Sequence[np.ndarray]) -> float:
        ex = self.search.examination
        missed = np.abs(ex.energy - np.mean(energies, axis=0)) * ex.count
        excess = np.abs(ex.energy - ex.replica_energy.mean(axis=0)) * ex.count
        return 1 - float(missed.sum() / excess.sum())


def _signatures(
    fmu: Simulator,
    setting: Setting,
    plain: Robot,
    floors: tuple[Sequence[Floor], Floor],
    others: Sequence[Repeat],
    seeds: Sequence[int],
) -> list[tuple[Residuals, Residuals, np.ndarray]]:
    """Residuals of the model without the law in replicas of the one with it: fitted, elsewhere; energy."""
    own = replicas_of(fmu, setting, setting.repeats, seeds)
    other = replicas_of(fmu, setting, others, [seed + _REPLICAS for seed in seeds])
    found = []
    for fitted, unseen in zip(own, other, strict=True):
        data = whitened(plain, fitted, floors[0])
        base = solve_base(data)
        elsewhere, own_energy = _elsewhere(plain, unseen, floors[1], base.p), energy(data, base.residual)[0]
        found.append((base.residual, elsewhere, own_energy))
    return found


def _distance(data: Residuals, signatures: Sequence[Residuals] = ()) -> float:
    """Energy of the difference between residuals and the mean of signatures."""
    mean = [np.mean(each, axis=0) for each in zip(*signatures, strict=True)] or [0.0] * len(data)
    return sum(float(np.square(r - s).sum()) for r, s in zip(data, mean, strict=True))


def _elsewhere(plain: Robot, logs: Sequence[Log], level: Floor, p: np.ndarray) -> Residuals:
    """Residuals in logs to which p was not fitted."""
    return [e.y - e.A @ p for e in whitened(plain, logs, [level] * len(logs))]


def law_values(trace: Trace) -> tuple[dict[str, float], dict[str, float]]:
    """Values and standard deviations of a trace's law."""
    c, setting = trace.candidate, trace.setting
    law = law_of(setting.robot, c)
    names = {p.name: parameter_name(c.joint, c.effect, p.name) for p in law.parameters}
    values = {name: setting.robot.parameters[full] for name, full in names.items()}
    columns, std = setting.reduced.columns, setting.solution.std
    known = {p.name: float(std[columns.index(names[p.name])]) for p in law.linear}
    return values, known | {p.name: float("inf") for p in law.nonlinear}
