"""From logged signals to what the regression needs: q and its derivatives, torques at the same instants.

A digital controller holds its torque: τ_k acts from t_k to t_{k+1}, so accelerations jump at every sample
and a derivative "at t_k" does not exist. What does exist is the mean under the hat function that rises from
t_{k−1} to t_k and falls to t_{k+1}. With the hat as test function of the weak form

    mean of q̈ = (q_{k−1} − 2 q_k + q_{k+1}) / T²      exactly, whatever happens between the samples,
    mean of τ = (τ_{k−1} + τ_k) / 2                    exactly, for a held torque,
    mean of q̇ = Σ_{i=1..4} c_i (q_{k+i} − q_{k−i}) / T + O(T⁸),
    mean of q = (−q_{k−2} + 24 q_{k−1} + 194 q_k + 24 q_{k+1} − q_{k+2}) / 240 + O(T⁶),

with the c_i for which every polynomial of degree 8 has its own mean: under a hat of width T the mean of
d(t^n)/dt is 2 T^(n-1) / (n + 1) for odd n, so Σ c_i i^n = 1 / (n + 1) for n = 1, 3, 5, 7. (The derivative at
the sample is another thing: at 50 Hz and 250 samples a second it is 13 % larger.) Φ, evaluated at the means,
belongs to the mean torque. Without a held torque the paper's eighth-order central
differences are taken at the samples themselves.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.coordinate import switch_of
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing
from pyident.conditioning.filters import settling, without_phase
from pyident.conditioning.motion import Motion
from pyident.conditioning.reversals.rest import REACH as REST_REACH
from pyident.conditioning.reversals.rest import at_samples
from pyident.conditioning.reversals.rubbing import known_where, rubs, signs_known, speed_products
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.standing import stands
from pyident.logs.log import Log, LogError, Sampled, require

REACH = 4  # samples that the widest difference needs on either side
# Central differences of eighth order (Khan and Ohba 2003): offsets 0 to 4.
_FIRST = np.array([0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SECOND = np.array([-205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
_HAT_MEAN = np.array([194 / 240, 24 / 240, -1 / 240])
_ODD = np.arange(1, 2 * REACH, 2)
_HAT_FIRST = np.append(0.0, np.linalg.solve(np.arange(1.0, REACH + 1) ** _ODD[:, None], 1 / (_ODD + 1)))
_HAT_SECOND = np.array([-2.0, 1.0])
_SETTLING = 50  # samples that a zero-phase filter's ends may spoil


@dataclass(frozen=True)
class Recipe:
    """How the signals of a robot's log with period [s], begun at a time [s], become equations."""

    robot: Robot
    period: float
    began: float
    low_pass: np.ndarray | None

    @property
    def names(self) -> list[str]:
        """The signals that it needs, in their order: coordinates, torques, time."""
        return [*self.robot.coordinates, *self.robot.torques, "time"]

    @property
    def border(self) -> int:
        """Samples that the filter spoils at either end of a log."""
        return _SETTLING if self.low_pass is not None else 0

    @property
    def reach(self) -> int:
        """Samples on either side on which an aligned sample depends."""
        return REACH + (settling(self.low_pass) if self.low_pass is not None else 0)

    @property
    def mask_reach(self) -> int:
        """Aligned samples on either side on which the mask of one depends."""
        return REST_REACH

    def aligned(self, signals: np.ndarray) -> Conditioned:
        """Signals (N, names) -> N − 2 REACH samples, every equation in use; times count from the start."""
        robot, n, joints = self.robot, len(self.robot.coordinates), len(self.robot.joints)
        q, torque, time = signals[:, :n], signals[:, n : n + joints], signals[REACH:-REACH, -1] - self.began
        if self.low_pass is not None:
            q = without_phase(self.low_pass, q)
        held = robot.controller is not None or derivatives_of(robot) is hat_means
        before = torque
        if held:
            before = np.concatenate([torque[:1], torque[:-1]])
        q, dq, ddq = derivatives_of(robot)(q, self.period)
        torque, before, target = torque[REACH:-REACH], before[REACH:-REACH], np.zeros_like(q)
        target[:, :joints] = (torque + before) / 2
        motion = Motion(q, dq, ddq, torque, time, before if held else None)
        return Conditioned(motion, target, np.ones_like(target), robot.settings.processing.decimate)

    def masked(self, part: Conditioned, products: np.ndarray) -> Conditioned:
        """Without the equations in which friction is not known; products: as of `speed_products`."""
        moving = _off_rest if part.thinning > 1 else _moving
        return replace(part, use=part.use * moving(self.robot, part.motion.dq, products))


def recipe(log: Sampled, robot: Robot) -> Recipe:
    """What the robot's [processing] asks of a log. Raises LogError."""
    plan = robot.settings.processing
    require(log, robot, _needed(plan, len(robot.linear_parameters)))
    return Recipe(robot, log.period, log.began, None if plan.cutoff is None else _low_pass(plan, log))


def condition(log: Log, robot: Robot) -> Conditioned:
    """Differentiate the coordinates and align the torques, as the robot's [processing] says.

    Raises LogError.
    """
    plan = recipe(log, robot)
    whole = plan.aligned(log.signals(plan.names))
    part = whole.cut(slice(plan.border, len(whole.target) - plan.border))
    masked = plan.masked(part, speed_products(part.motion.dq, len(robot.joints)))
    positions = part.motion.q[:, : len(robot.joints)]
    for rub in rubs(robot):  # noise keeps its sign for a few samples, too
        if stands(rub.of(positions), positions):
            masked.use[:, rub.rows] = 0.0
    masked.use[switching(log, robot, REACH + 1, len(masked.use))] = 0.0
    free = tuple(k for k, name in enumerate(robot.torques) if name in log.up_to_constant)
    return replace(masked, free=free)


def switching(log: Log, robot: Robot, reach: int, samples: int) -> np.ndarray:
    """(samples,) in a log's middle: those near where a servo goes on or off, so that its torque jumps."""
    near = np.zeros(len(log), bool)
    for name in (switch_of(k) for k, _ in robot.numbered if switch_of(k) in log.frame):
        on = log.frame[name].to_numpy(float) > 0.5
        for at in np.flatnonzero(np.diff(on)).tolist():
            near[max(at + 1 - reach, 0) : at + 1 + reach] = True
    ends = (len(log) - samples) // 2
    return near[ends : ends + samples]


def condition_every_sample(log: Log, robot: Robot) -> Conditioned:
    """The same with each sample an equation of its own where the robot's [processing] thins them out.

    Equations that are thinned out keep reversals, for a low pass has carried these to their neighbours. A
    Fourier coefficient is a sum over samples, in which those near rest can be left out as they are elsewhere.
    Raises LogError.
    """
    part = condition(log, robot)
    if part.thinning == 1:
        return part
    dq = part.motion.dq
    moving = _moving(robot, dq, speed_products(dq, len(robot.joints)))
    return replace(part, use=part.use * moving, thinning=1)


def central_differences(q: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, dq, ddq at the samples, of eighth order: the paper's scheme. q (N, n) -> three (N - 8, n)."""
    return q[REACH:-REACH], _odd(q, _FIRST) / period, _even(q, _SECOND) / period**2


def hat_means(q: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means of q, dq, ddq under the hat function of each sample. q (N, n) -> three (N - 8, n)."""
    return _even(q, _HAT_MEAN), _odd(q, _HAT_FIRST) / period, _even(q, _HAT_SECOND) / period**2


DERIVATIVES: dict[str, Callable] = {"central": central_differences, "hat": hat_means}


def derivatives_of(robot: Robot) -> Callable:
    """The scheme that the robot's [processing] names; without a name that which fits its torque."""
    return DERIVATIVES[robot.settings.processing.derivative or ("hat" if robot.controller else "central")]


def _even(q: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Symmetric stencil: weights of offsets 0, ±1, ±2 ..."""
    n = len(q) - 2 * REACH
    out = weights[0] * q[REACH : REACH + n]
    for i, weight in enumerate(weights[1:], start=1):
        out += weight * (q[REACH + i : REACH + i + n] + q[REACH - i : REACH - i + n])
    return out


def _odd(q: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Antisymmetric stencil: weights of offsets +1, +2 ..."""
    n = len(q) - 2 * REACH
    out = np.zeros((n, *q.shape[1:]))
    for i, weight in enumerate(weights[1:], start=1):
        out += weight * (q[REACH + i : REACH + i + n] - q[REACH - i : REACH - i + n])
    return out


def _moving(robot: Robot, dq: np.ndarray, products: np.ndarray) -> np.ndarray:
    """(N, n): 0 where the sign of an equation's dry friction is not known, 1 elsewhere."""
    return signs_known(robot, at_samples(dq) if derivatives_of(robot) is hat_means else dq, products)


def _off_rest(robot: Robot, dq: np.ndarray, _: np.ndarray) -> np.ndarray:
    """(N, n): 0 below the dead zone of an equation's dry friction; a reversal is a small part of what is
    thinned out and stays, with the mean sign of its speeds."""
    zone = robot.settings.processing.dead_zone
    return known_where(robot, lambda rub: np.abs(rub.of(dq)) >= zone, dq.shape)


def _low_pass(plan: Processing, log: Sampled) -> np.ndarray:
    from scipy.signal import butter

    nyquist = 0.5 / log.period
    assert plan.cutoff is not None
    if plan.cutoff >= nyquist:
        raise LogError(
            f"{log.source}: the cutoff of {plan.cutoff:g} Hz needs more than {2 * plan.cutoff:g} samples a "
            f"second, the log has {2 * nyquist:g}; lower processing.cutoff in the robot file"
        )
    return np.asarray(butter(plan.order, plan.cutoff / nyquist, output="sos"))


def _needed(plan: Processing, parameters: int) -> int:
    """Samples without which the equations cannot be more than the unknowns."""
    border = 2 * REACH + (2 * _SETTLING if plan.cutoff is not None else 0)
    return border + max(50, parameters) * plan.decimate
