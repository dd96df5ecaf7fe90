"""Springs of drives that are fitted together with a robot's parameters, in rounds.

Springs bend what links need, and what links need bends springs: both are sought in turns until the springs
rest. Of the inertia that follows a motor, a fit without springs does not tell what is the motor's own; it
decides how links swing, and is sought with the springs.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from flexmodels.coordinate import of_joint
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.diagnosis.base.candidates import Candidate, columns, drive
from pyident.diagnosis.base.projection import Base, Columns, extended, gain, joined, taken_over
from pyident.regression.loads.swinging_drive import (
    NO_SPRINGS,
    Spring,
    Springs,
    ringing,
    swung,
    typical_inertia,
    up_to,
)
from pyident.regression.spectrum import Equations

DAMPING = (0.02, 0.1)  # ratios
_LOOKS = 6  # steps towards other springs
_WITHIN, _STEP = 1.5, 1e-3  # of logarithms of compliances and dampings
_SHARE, _INSIDE = (0.02, 1.0), (0.03, 0.97)  # of the inertia that follows a motor that may be the link's
_TRUSTED = np.array([0.5, 1.0, 0.5])  # of what is known of these: standard deviations
_MOST = 1.0  # of a damping ratio: beyond, nothing swings
_RESTS = 0.02  # of a compliance
_ALIKE = 4.0  # times: so far may the size of a swing be from that of the spring that makes it


@dataclass(frozen=True)
class Whitened:
    """Equations of logs over levels (n, E) each, and their base."""

    logs: Sequence[Equations]
    levels: Sequence[np.ndarray]
    base: Base


@dataclass(frozen=True)
class Fit:
    """A robot fitted with springs of drives, none: with the slope of that, and the energy that these take.

    beside   what else is fitted with them
    rings    whether links may ring as each log begins, as where a log begins in motion
    """

    robot: Robot
    drives: Mapping[int, Spring | None]
    energy: float = 0.0
    beside: tuple[Candidate, ...] = ()
    rings: bool = False

    @property
    def springs(self) -> Springs:
        return {k: spring for k, spring in self.drives.items() if spring is not None}

    @property
    def all_swinging(self) -> "Fit":
        """The same, with a damping for links that only sag."""
        damped = {k: s if s.swings else replace(s, damping=DAMPING[-1]) for k, s in self.springs.items()}
        return replace(self, drives={**self.drives, **damped})

    @property
    def swings(self) -> Springs:
        return {k: spring for k, spring in self.springs.items() if spring.swings}


def settled(w: Whitened, fit: Fit, rounds: int) -> Fit:
    """The fit with its springs sought anew from those it has, in rounds with the parameters."""
    found = best = replace(fit, energy=0.0)
    for _ in range(rounds if fit.swings else 0):
        before = found.swings
        found, compliances = fitted_beside(w, sought(w, found))
        sizes = [compliances[k] / spring.compliance for k, spring in found.swings.items()]
        if all(1 < _ALIKE * size < _ALIKE**2 for size in sizes) and found.energy > best.energy:
            best = found
        moved = [abs(np.log(s.compliance / before[k].compliance)) for k, s in found.swings.items()]
        if max(moved) < _RESTS:
            break
    return best


def sought(w: Whitened, fit: Fit, known: Springs = NO_SPRINGS) -> Fit:
    """The fit with springs about its own that leave least of all equations, beside drives that only sag.

    Of the inertia that follows a motor, how much is its own is sought as well: it decides how links swing.

    known   of the same drives: near them stays what the logs do not tell; none: nothing is known
    """
    springs = fit.swings
    if any(spring.compliance <= 0 or spring.damping <= 0 for spring in springs.values()):
        return fit  # a spring that pushes is none
    motion = w.logs[0].part.motion
    inertias = {k: inertias_at(fit.robot, motion, k) for k in springs}
    if any(whole <= 0 for _, whole in inertias.values()):
        return fit  # of bodies that no robot has
    base = _beside_swings(w, fit)
    usual = _coordinates(known, inertias)

    def left(x: np.ndarray) -> np.ndarray:
        rows = x.reshape(-1, 3)
        away = (rows - usual) / _TRUSTED if known else np.zeros(0)
        rest = _rest(w, base, fit.robot, _springs_at(rows, inertias))
        return np.concatenate([*(r.ravel() for r in rest), away.ravel()])

    start = _coordinates(springs, inertias)
    start[:, 2] = np.clip(start[:, 2], *_INSIDE)
    lowest, highest = start - _WITHIN, start + _WITHIN
    highest[:, 1] = np.maximum(start[:, 1], math.log(_MOST)) + _RESTS
    lowest[:, 2], highest[:, 2] = _SHARE
    ends = lowest.ravel(), highest.ravel()
    found = least_squares(left, start.ravel(), bounds=ends, diff_step=_STEP, max_nfev=_LOOKS)
    return replace(fit, drives={**fit.drives, **_springs_at(found.x.reshape(-1, 3), inertias)})


def _beside_swings(w: Whitened, fit: Fit) -> Base:
    """The base with what is fitted beside the links that swing, and what these begin with."""
    base = base_beside(w, replace(fit, drives={k: s for k, s in fit.drives.items() if k not in fit.swings}))
    return extended(base, _ringing(w, fit)) if fit.rings else base


def stiffness_std(w: Whitened, fit: Fit) -> dict[int, float]:
    """Standard deviation of the logarithm of each stiffness, beside all that is sought with it.

    By the slopes of what is left in all dampings, shares of inertia and stiffnesses; infinite where the logs
    do not tell these apart.
    """
    springs, motion = fit.swings, w.logs[0].part.motion
    inertias = {k: inertias_at(fit.robot, motion, k) for k in springs}
    base = _beside_swings(w, fit)
    at = _coordinates(springs, inertias)

    def left(x: np.ndarray) -> np.ndarray:
        rest = _rest(w, base, fit.robot, _springs_at(x.reshape(-1, 3), inertias))
        return np.concatenate([r.ravel() for r in rest])

    steps = _STEP * np.eye(at.size)
    slopes = np.array([(left(at.ravel() + h) - left(at.ravel() - h)) / (2 * _STEP) for h in steps])
    information = slopes @ slopes.T
    if np.linalg.matrix_rank(information, hermitian=True) < at.size:
        return dict.fromkeys(springs, np.inf)
    spread = np.sqrt(np.diag(np.linalg.inv(information)))[::3]
    return dict(zip(springs, spread.tolist(), strict=True))


def left_beside(w: Whitened, fit: Fit) -> list[np.ndarray]:
    """Per log (n, E): what is left beside what links do on springs, and what else is fitted with them."""
    rest, others = w.base, _columns(w, replace(fit, drives={}))
    if fit.swings:
        rest = replace(rest, residual=_rest(w, rest, fit.robot, fit.swings))
        others += [_ringing(w, fit)] if fit.rings else []
    return extended(rest, joined(others)).residual if others else rest.residual


def fitted_beside(w: Whitened, fit: Fit) -> tuple[Fit, dict[int, float]]:
    """The fit with parameters fitted together with its drives, columns at those before; and compliances."""
    X = joined(_columns(w, fit))
    found = gain(w.base, X)
    p = w.base.p - taken_over(w.base, X) @ found.coefficients
    robot = fit.robot.with_parameters(dict(zip(fit.robot.linear_parameters, p.tolist(), strict=True)))
    told = dict(zip(fit.drives, found.coefficients.tolist(), strict=False))
    return replace(fit, robot=robot, energy=found.energy), told


def base_beside(w: Whitened, fit: Fit) -> Base:
    """The base with the drives of a fit, and what is fitted with them."""
    return extended(w.base, joined(_columns(w, fit))) if fit.drives or fit.beside else w.base


def _columns(w: Whitened, fit: Fit) -> list[Columns]:
    """Of each drive of a fit, and of what is fitted with them."""
    listed = [*(drive(k, up_to(fit.springs, k)) for k in fit.drives), *fit.beside]
    return [columns(fit.robot, c, w.logs, w.levels) for c in listed]


def _ringing(w: Whitened, fit: Fit) -> Columns:
    """What links change that ring as a log begins, a column for each way and log."""
    several = 2 * len(fit.swings) * len(w.logs)
    listed: Columns = [
        {row: np.zeros((log.y.shape[1], several)) for row in range(len(log.y))} for log in w.logs
    ]
    for i, (log, level) in enumerate(zip(w.logs, w.levels, strict=True)):
        rung = ringing(fit.robot, log.part.motion, fit.swings)
        own = slice(i * len(rung), (i + 1) * len(rung))
        for row, X in listed[i].items():
            X[:, own] = log.band.transform(log.part.used(row, rung[:, row]).T) / level[row][:, None]
    return listed


def _rest(w: Whitened, base: Base, robot: Robot, springs: Springs) -> list[np.ndarray]:
    """Per log (n, E): what a base leaves beside the whole of what links do on their springs."""
    changed = _changed(w, robot, springs)
    imitated = sum(np.tensordot(c, own, 2) for c, own in zip(changed, base.basis, strict=True))
    each = zip(base.residual, changed, base.basis, strict=True)
    return [r - c + own @ imitated for r, c, own in each]


def _coordinates(springs: Springs, inertias: Mapping[int, tuple[float, float]]) -> np.ndarray:
    """(S, 3) logarithms of compliance and damping, and the link's share of what follows its motor."""
    pairs = ((s, *inertias[k]) for k, s in springs.items())
    rows = [(math.log(s.compliance), math.log(s.damping), (J - s.rotor) / whole) for s, J, whole in pairs]
    return np.array(rows).reshape(-1, 3)


def _springs_at(rows: np.ndarray, inertias: Mapping[int, tuple[float, float]]) -> Springs:
    """Of `_coordinates`."""
    pairs = zip(inertias.items(), rows.tolist(), strict=True)
    return {
        k: Spring(math.exp(c), math.exp(z), J - share * whole) for (k, (J, whole)), (c, z, share) in pairs
    }


def _changed(w: Whitened, robot: Robot, springs: Springs) -> list[np.ndarray]:
    """Per log (n, E): what links that swing change in the equations."""
    out = []
    for log, level in zip(w.logs, w.levels, strict=True):
        change = swung(robot, log.part.motion, springs)
        used = np.array([log.part.used(row, own) for row, own in enumerate(change)])
        out.append(log.band.transform(used.T).T / level)
    return out


def inertias_at(robot: Robot, motion: Motion, joint: int) -> tuple[float, float]:
    """What the links have at a joint, from 1, and that with its motor's: no fit may tell how it is shared."""
    links = typical_inertia(robot, motion, joint)
    return links, links + robot.parameters.get(of_joint(joint, "J_m"), 0.0)


def like_links(links: float, whole: float) -> float:
    """An inertia that links may have, of inertias as `inertias_at` gives: their own, if that is one."""
    return links if links > _SHARE[0] * whole else whole / 2
