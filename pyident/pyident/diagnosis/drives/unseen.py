"""Drives that bend by the robot's file, in logs of their motors alone.

Without a link-side encoder the hinge of such a drive is locked, and what its link does on the spring is a
residual. But a link that swings is felt by its motor: the spring, its damping and how much of the inertia is
the motor's are sought in the logs, from what the file says of the spring, beside a delay of every torque. The
torques are then put right for what the links do, and all else is asked of a robot whose drives are rigid.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from flexmodels.coordinate import of_joint
from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.base.replicas import levels_by_rest
from pyident.diagnosis.drives.springs import (
    Fit,
    Whitened,
    inertias_at,
    left_beside,
    like_links,
    sought,
    stiffness_std,
)
from pyident.estimation.estimator import weighted
from pyident.estimation.identify import identified
from pyident.estimation.lock_unlogged import locked_in
from pyident.logs.log import Log, LogError
from pyident.regression.descriptions import LATE, description_names
from pyident.regression.equations import Problem
from pyident.regression.loads.swinging_drive import Spring, Springs, carry, ringing, swung
from pyident.regression.regressor import residual_of
from pyident.regression.spectrum import Equations, all_over, floors, levels_of
from pyident.simulation.denoised import (
    denoised,
    denoised_equations,
    denoised_every_sample,
    denoises,
    unfiltered,
)

_ROUNDS = 15  # of springs, parameters and weights
_RESTS = 0.01  # of what is left at a frequency, on average
_DAMPED = (0.01, 0.3)  # ratios to begin with
_SWINGS = 0.1  # of a damping ratio: beyond, springs may take what something else has left
_STARTS = (1.0, 1.6, 0.6, 3.0, 0.33)  # times the stiffnesses of the file
_ALIKE = 0.05  # of a stiffness: so near do starts come that end at one place
_LEVEL = 0.01  # of the logarithm of what is left: so near are fits that leave alike
_SURE = 0.03  # of the logarithm of a stiffness: one that the logs tell less surely is not told
_GEARS = 0.3  # of a damping ratio, that none of a drive exceeds: what is damped more is something else
_CHANCE = 25.0  # energy that noise gives to a column: five standard deviations


@dataclass(frozen=True)
class UnseenDrives:
    """A robot of rigid drives, and the springs on which its links swing, by joint."""

    robot: Robot
    springs: Springs

    def rigid(self, log: Log) -> Log:
        """The log with the torques that rigid drives would have needed; as it is where no spring carries."""
        part = denoised_every_sample(unfiltered(self.robot, [log]), log)
        motion = part.motion
        if not carry(self.robot, motion, self.springs):
            return log
        change = swung(self.robot, motion, self.springs)
        change += self._rung(part, change)
        time = log.frame["time"].to_numpy(float)
        if motion.tau_before is not None:  # equations take a mean of two, half a sample late
            time = time + log.period / 2
        rigid = {
            name: log.frame[name] - np.interp(time, np.asarray(motion.time), own, 0.0, 0.0)
            for name, own in zip(self.robot.torques, change, strict=True)
        }
        return replace(log, frame=log.frame.assign(**rigid))

    def _rung(self, part: Conditioned, change: np.ndarray) -> np.ndarray:
        """(n, N) what links change that ring as the log begins, by what is left beside the change (n, N)."""
        left = residual_of(self.robot, part, np.array(list(self.robot.linear_parameters.values())))
        rung = ringing(self.robot, part.motion, self.springs)
        X = np.array([part.all_used(own.T) for own in rung]).reshape(len(rung), -1)
        size = np.linalg.lstsq(X.T, (left - part.all_used(change.T)).ravel(), rcond=None)[0]
        return np.tensordot(size, rung, 1)

    def hinges(self, log: Log) -> dict[int, dict[str, float]]:
        """By joint its `k[1]`, `d[1]` and `J_m`; damping by the inertia that its link has along a log."""
        motion, told = _motion(self.robot, log), {}
        for k, spring in self.springs.items():
            links, whole = inertias_at(self.robot, motion, k)
            behind, K = links - spring.rotor, 1 / spring.compliance
            D = 2 * spring.damping * math.sqrt(behind * K)
            told[k] = {"k[1]": K, "d[1]": D, "J_m": whole - behind}
        return told


def hinge_notes(hinges: Mapping[int, Mapping[str, float]]) -> Iterator[str]:
    """A sentence on each joint's hinge, as found in logs."""
    for k, own in hinges.items():
        yield (
            f"joint {k}: no link-side encoder; by what its motor feels of how its link swings, its hinge "
            f"has k[1] = {own['k[1]']:.4g} N.m/rad and d[1] = {own['d[1]']:.2g} N.m.s/rad, and its motor "
            f"J_m = {own['J_m']:.3g} kg.m2 (no intervals); torques are taken as rigid drives need them"
        )


def unseen(whole: Robot, robot: Robot) -> list[int]:
    """Joints, from 1, whose hinges a robot's file gives a stiffness, and the robot of its logs has locked.

    None where a loop is simulated.
    """
    if not denoises(robot) or whole.servo or robot.closures or robot.passive:
        return []
    turning = [k for k in locked_in(whole, robot) if whole.joints[k - 1].kind == "revolute"]
    return [k for k in turning if whole.parameters.get(of_joint(k, "k[1]"), 0.0) > 0]


def stated(whole: Robot, robot: Robot, log: Log) -> UnseenDrives | None:
    """The springs of a robot's file with its own bodies and motors; None where it has none."""
    if not unseen(whole, robot):
        return None
    springs = _of_file(whole, robot, _motion(robot, log), lambda links, _: links)
    return UnseenDrives(robot, springs) if springs else None


def found(whole: Robot, robot: Robot, logs: Sequence[Log]) -> UnseenDrives | None:
    """The springs of a robot's file as logs show them, beside a rigid robot that is fitted with them.

    Bodies and motors of the file are never used. Springs that the logs hardly tell, or that take no more than
    noise gives, are left out; None where none is left, or no bodies that can exist go with them. Raises
    LogError.
    """
    if not unseen(whole, robot):
        return None
    plain = unfiltered(robot, logs)
    data = denoised_equations(plain, logs)
    begun = _over(data, levels_by_rest(data, [np.ones_like(e.y) for e in data]))
    told = []
    for motion in (denoised, _as_logged):
        told_from = partial(_told, robot=plain, logs=logs, data=data, w=begun, motion=motion)
        own, left = _best_told(whole, unseen(whole, robot), told_from)
        if own is not None:
            told.append((left, own))
        if own is not None and _all_swing(own, unseen(whole, robot)):
            break  # a low pass blurs axes that stand most of the time; their motion keeps its noise then
    if not told:
        return None
    _, best = min(told, key=lambda pair: pair[0])
    return UnseenDrives(replace(best.robot, settings=robot.settings), best.springs)


def _all_swing(drives: UnseenDrives, joints: Sequence[int]) -> bool:
    """Whether links of joints, from 1, all swing more than once."""
    return set(drives.springs) == set(joints) and all(s.damping < _SWINGS for s in drives.springs.values())


def _as_logged(robot: Robot, log: Log) -> Conditioned:
    return condition(log, robot)


def _best_told(
    whole: Robot, joints: Sequence[int], told: Callable[[Robot], tuple[UnseenDrives | None, float]]
) -> tuple[UnseenDrives | None, float]:
    """As `_told`, from several stiffnesses of joints about the file's, until two starts end at one place.

    None where other stiffnesses leave as little as the best: then logs do not tell them.
    """
    stiffnesses = [of_joint(k, "k[1]") for k in joints]
    ends: list[tuple[float, UnseenDrives]] = []
    for times in _STARTS:
        stiff = {name: times * whole.parameters[name] for name in stiffnesses}
        own, left = told(whole.with_parameters(stiff))
        if own is None:
            continue
        ends.append((left, own))
        ends.sort(key=lambda end: end[0])
        alike = [other for least, other in ends[1:] if least < ends[0][0] + _LEVEL]
        if any(_same(ends[0][1], other) for other in alike):
            return ends[0][1], ends[0][0]
    if not ends or any(least < ends[0][0] + _LEVEL for least, _ in ends[1:]):
        return None, math.inf
    return ends[0][1], ends[0][0]


def _same(one: UnseenDrives, other: UnseenDrives) -> bool:
    """Whether they have the same springs, but for little."""
    pairs = [(one.springs[k], other.springs[k]) for k in one.springs if k in other.springs]
    near = all(abs(math.log(a.compliance / b.compliance)) < _ALIKE for a, b in pairs)
    return near and one.springs.keys() == other.springs.keys()


def _told(
    whole: Robot,
    robot: Robot,
    logs: Sequence[Log],
    data: Sequence[Equations],
    w: Whitened,
    motion: Callable[[Robot, Log], Conditioned],
) -> tuple[UnseenDrives | None, float]:
    """The same of a robot without filter, whose bodies are fitted to logs as `motion` conditions them.

    And the mean logarithm of what is left. None also where rounds do not come to rest.

    data   equations of the logs;  w: the same over what rigid drives leave
    """
    nothing = None, math.inf
    own = _fitted(robot, logs, motion)
    known = _of_file(whole, own, data[0].part.motion, like_links)
    if not known:
        return nothing
    lags = [Candidate(LATE, k) for k, _ in robot.numbered if LATE in description_names(robot, k)]
    fit = Fit(own, known, beside=tuple(lags), rings=True)
    for _ in range(_ROUNDS):
        fit, before = sought(w, fit, known), w.levels
        try:
            rigid = UnseenDrives(fit.robot, fit.springs).rigid
            fit = replace(fit, robot=_fitted(robot, [rigid(log) for log in logs], motion))
        except LogError:
            return nothing
        left = left_beside(w, fit)
        if _energy(left) > w.base.energy:
            return nothing
        left = [r * level for r, level in zip(left, w.levels, strict=True)]
        w = _over(data, levels_of(floors([e.band for e in data], left, len(data)), data))
        if all(np.abs(np.log(a / b)).mean() < _RESTS for a, b in zip(w.levels, before, strict=True)):
            break
    else:
        return nothing
    springs = _shown(w, fit) if carry(fit.robot, data[0].part.motion, fit.springs) else {}
    level = float(np.mean([np.log(at).mean() for at in w.levels]))
    return (UnseenDrives(fit.robot, springs), level) if springs else nothing


def _energy(left: Sequence[np.ndarray]) -> float:
    return sum(float(np.square(r).sum()) for r in left)


def _shown(w: Whitened, fit: Fit) -> Springs:
    """Springs of drives that the logs tell, without each of which more is left than noise makes."""

    def left(springs: Springs) -> float:
        return _energy(left_beside(w, replace(fit, drives=springs)))

    whole, each = left(fit.springs), fit.springs.items()
    without = {k: {j: other for j, other in each if j != k} for k, _ in each}
    spread = stiffness_std(w, fit)
    told = {k: spring for k, spring in each if spring.damping < _GEARS and spread.get(k, 0.0) < _SURE}
    return {k: spring for k, spring in told.items() if left(without[k]) - whole > _CHANCE}


def _fitted(robot: Robot, logs: Sequence[Log], motion: Callable[[Robot, Log], Conditioned]) -> Robot:
    """The rigid robot whose bodies can exist that goes with logs as `motion` conditions them."""
    best = weighted(Problem(robot, tuple(motion(robot, log) for log in logs)))
    return identified(robot, best.reduced, best.solution).robot


def _of_file(whole: Robot, robot: Robot, motion: Motion, behind: Callable[[float, float], float]) -> Springs:
    """The springs of a robot's file, by joint, with what is `behind` each of the inertias that it has."""
    springs = {}
    for k in unseen(whole, robot):
        links, both = inertias_at(robot, motion, k)
        K, J = whole.parameters[of_joint(k, "k[1]")], behind(links, both)
        if both <= 0 or J <= 0:
            return {}
        ratio = whole.parameters.get(of_joint(k, "d[1]"), 0.0) / (2 * math.sqrt(J * K))
        springs[k] = Spring(1 / K, float(np.clip(ratio, *_DAMPED)), links - J)
    return springs


def _over(data: Sequence[Equations], levels: list[np.ndarray]) -> Whitened:
    logs = all_over(data, levels)
    return Whitened(logs, levels, solve_base(logs))


def _motion(robot: Robot, log: Log) -> Motion:
    return denoised_every_sample(unfiltered(robot, [log]), log).motion
