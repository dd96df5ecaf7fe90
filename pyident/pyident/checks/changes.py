"""A machine that is another one from some instant of a log on: it took up a load, or a brake drags.

Any error of the model is smaller with more parameters, and where the first half of a log is slow and the
second fast, each has its own best set. So nothing is asked before everything that may be missing of one
machine has been given room: friction of any shape over speed, by load, that drifts, a spring, a zero that
drifts, drives that bend. Then only what can change in an instant may: the body of the last link, or one
joint's friction. A step is told from what grows by a second split: beside a step that gains little.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from flexmodels.coordinate import joint_name, torque_of
from pyident.checks.balances import Balances
from pyident.checks.defect import Defect
from pyident.logs.log import Log
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.log_checks import CHANGES, LOG_CHECKS

_SPLITS = 120  # instants that are tried first, before the samples around the best
_OPEN = 1e-6  # the largest eigenvalue of a candidate's equations, below which a direction is left alone


@dataclass(frozen=True)
class Change:
    """A step of the machine, at the sample `at` of the balances.

    left    share of the energy left by one machine that remains with the step
    again   share of that which remains with the best second step
    size    rms of what the step explains, over the rms of the torque (of the joint where this is most)
    first   difference of the candidate's first parameter; None where the log leaves it open
    """

    at: int
    left: float
    again: float
    size: float
    first: float | None


@dataclass(frozen=True)
class Candidate:
    """Parameters that may change in an instant: their columns (M, R, C) in the balances of R joints.

    rows   of the joints among those that move
    own    whether these rows alone are judged, not all
    """

    rows: Sequence[int]
    columns: np.ndarray
    own: bool


@dataclass(frozen=True)
class OneMachine:
    """What the best single machine leaves, in units of each joint's own level.

    Q        (M, n, r) orthonormal columns of everything one machine may be, over the samples of n joints
    left     (M, n) the rest
    weight   (n,) one over the joints' levels [1/(N m) or 1/N]; zero rows where a joint does not move
    """

    Q: np.ndarray
    left: np.ndarray
    weight: np.ndarray

    def beside(self, candidate: Candidate, at: int) -> "OneMachine":
        """The same with a step of a candidate from sample `at` on."""
        columns = np.zeros((*self.left.shape, candidate.columns.shape[2]))
        columns[at:, candidate.rows] = candidate.columns[at:]
        Q, flat = self.Q.reshape(self.left.size, -1), columns.reshape(self.left.size, -1)
        new = _orthonormal(flat - Q @ (Q.T @ flat), np.linalg.norm(flat, axis=0), _OPEN)
        left = self.left.ravel() - new @ (new.T @ self.left.ravel())
        both = np.concatenate([self.Q, new.reshape(*self.left.shape, -1)], axis=2)
        return OneMachine(both, left.reshape(self.left.shape), self.weight)

    def energy(self, candidate: Candidate) -> float:
        """Of the rows by which a candidate is judged."""
        rows = self.left[:, candidate.rows] if candidate.own else self.left
        return float(np.square(rows).sum())


def changes(of: Balances, log: Log) -> Iterator[Defect]:
    """The last link's body, or else the one joint's friction, that changed in the midst of a log."""
    if (one := one_machine(of)) is None:
        return
    time = log.frame["time"].to_numpy(float)[of.samples.at]
    if (body := last_body(of, one)) is not None and (found := step(of, one, body)) is not None:
        said = _defect(log.source, time[found.at], found, "",
                       f"The last link has another body{grown(found, 'kg')}: a load was taken up or put "
                       "down, or a tool was changed")  # fmt: skip
        yield replace(said, another_body=(log.source, float(time[found.at])))
        return
    frictions = [(k, step(of, one, friction(of, one, i))) for i, k in enumerate(of.joints)]
    told = [(f.left, k, f) for k, f in frictions if f is not None and _both_ways(of, k, f.at)]
    for _, k, found in sorted(told, key=lambda t: t[:2])[:1]:
        unit = "N m" if of.samples.robot.joints[k].kind == "revolute" else "N"
        yield _defect(log.source, time[found.at], found, torque_of(k + 1),
                      f"The friction of {joint_name(k + 1)} is another{grown(found, unit)}: a brake drags or "
                      "was let go, or something rubs")  # fmt: skip


def _both_ways(of: Balances, k: int, at: int) -> bool:
    """Whether joint k (from 0) moves either way before the sample `at` and after it: with one way alone, its
    friction is not told from all else that holds it."""
    way = np.sign(of.samples.dq[:, k]) * (of.samples.use[:, k] > 0)
    shares = [np.mean(part == sign) for part in (way[:at], way[at:]) for sign in (-1, 1)]
    return min(shares) >= CHANGES.edge


def one_machine(of: Balances) -> OneMachine | None:
    """What one machine leaves of a log's torques; None where there are too few equations to ask."""
    use = of.samples.use[:, of.joints] > 0
    if not of.joints:
        return None
    whole = _levels(of)
    A = _everything(of) * use[..., None]
    if use.sum() < EQUATIONS.per_parameter * A.shape[2]:
        return None
    y = of.torque[:, of.joints] * use
    first = _fitted(A, y, 1 / whole)  # by the joints' torques, then by what is left of them
    level = np.sqrt(np.square(first.left).sum(axis=0) / use.sum(axis=0)) * whole
    return _fitted(A, y, 1 / np.maximum(level, LOG_CHECKS.torque_floor * whole))


def _levels(of: Balances) -> np.ndarray:
    """(n,) rms of the torques about their means; of a joint that carries nothing, a little of the others'."""
    level = np.sqrt([of.variance(k) / of.samples.use[:, k].sum() for k in of.joints])
    return np.maximum(level, max(CHANGES.light * float(level.max()), 1e-300))


def _fitted(A: np.ndarray, y: np.ndarray, weight: np.ndarray) -> OneMachine:
    """A (M, n, C), y (M, n), weight (n,)."""
    weighted, flat = (A * weight[:, None]).reshape(y.size, -1), (y * weight).ravel()
    Q = _orthonormal(weighted, np.linalg.norm(weighted, axis=0), EQUATIONS.determined)
    left = flat - Q @ (Q.T @ flat)
    return OneMachine(Q.reshape(*y.shape, -1), left.reshape(y.shape), weight)


def _everything(of: Balances) -> np.ndarray:
    """(M, n, C) the model's columns for the joints that move, and what each of these may have beside."""
    bent = _snaps(of)
    room = [np.column_stack([_room(of, k), bent]) for k in of.joints]
    own = np.zeros((len(of.samples.at), len(room), len(room), room[0].shape[1]))
    for i, columns in enumerate(room):
        own[:, i, i] = columns
    return np.concatenate([of.Phi[:, of.joints], own.reshape(*own.shape[:2], -1)], axis=2)


def _room(of: Balances, k: int) -> np.ndarray:
    """(M, C) what one machine may have at joint k (from 0) beyond the model."""
    own = of.samples
    speed, angle, way = own.dq[:, k], own.q[:, k], own.direction[:, k]
    size, along = np.abs(speed), np.linspace(-1, 1, len(own.at))
    bends = np.quantile(size[own.use[:, k] > 0], CHANGES.bends)
    shape = [np.clip((size - a) / max(b - a, 1e-300), 0, 1) for a, b in pairwise(bends)]
    steady = [np.ones_like(speed), way, speed, angle - angle.mean(), way * np.abs(of.torque[:, k])]
    drifts = [x * along**i for x in steady[:3] for i in (1, 2)]
    return np.column_stack([*steady, *drifts, *shape, *(way * x for x in shape)])


def _snaps(of: Balances) -> np.ndarray:
    """(M, joints) second derivatives of the accelerations: what drives that bend add to the torques.

    Of one log in the fast and the slow half of which they bend otherwise, each would be another body.
    """
    own = of.samples
    step = own.period * float(np.median(np.diff(own.at)))
    return np.gradient(np.gradient(own.ddq[:, of.joints], axis=0), axis=0) / step**2


def last_body(of: Balances, one: OneMachine) -> Candidate | None:
    """The ten parameters of the last link; None of a robot with loops, where the last holds no tool."""
    robot = of.samples.robot
    prefix = f"link{len(robot.links)}."
    own = [i for i, name in enumerate(of.columns) if name.startswith(prefix)]
    if robot.closures or not own:
        return None
    use = of.samples.use[:, of.joints] > 0
    columns = of.Phi[:, of.joints][..., own] * use[..., None] * one.weight[:, None]
    return Candidate(range(len(of.joints)), columns, own=False)


def friction(of: Balances, one: OneMachine, row: int) -> Candidate:
    """Dry and viscous friction of one of the joints that move."""
    k = of.joints[row]
    use = of.samples.use[:, k] > 0
    columns = np.column_stack([of.samples.direction[:, k], of.samples.dq[:, k]]) * use[:, None]
    return Candidate([row], one.weight[row] * columns[:, None], own=True)


def step(of: Balances, one: OneMachine, candidate: Candidate) -> Change | None:
    """Where a candidate steps; None where it does not, or the log may be explained otherwise."""
    coarse, edge = _instants(len(one.left))
    M, apart = len(one.left), int(coarse[1] - coarse[0])
    best = int(coarse[np.argmax(_gains(one, candidate, coarse))])
    near = np.arange(max(edge, best - apart), min(M - edge, best + apart + 1))
    at = int(near[np.argmax(_gains(one, candidate, near))])
    if at in (edge, M - edge - 1):  # it explains the more, the further out it lies
        return None
    return step_at(of, one, candidate, at)


def step_at(of: Balances, one: OneMachine, candidate: Candidate, at: int) -> Change | None:
    """The same at a sample that is known."""
    after = one.beside(candidate, at)
    energy, left = one.energy(candidate), after.energy(candidate)
    most = CHANGES.friction if candidate.own else CHANGES.body
    size = _size(of, one, after)
    if left > most * energy or size < LOG_CHECKS.torque_floor:
        return None
    coarse, edge = _instants(len(one.left))
    others = coarse[np.abs(coarse - at) > edge // 2]
    again = 1 - float(_gains(after, candidate, others).max()) / max(left, 1e-300)
    if again < CHANGES.again:
        return None
    return Change(at, left / energy, again, size, _first(one, candidate, at))


def _instants(count: int) -> tuple[np.ndarray, int]:
    """Samples (S,) of `count` at which a step is tried, and how far from either end none is."""
    edge = int(np.ceil(CHANGES.edge * count))
    return np.arange(edge, count - edge, max(1, (count - 2 * edge) // _SPLITS)), edge


def _gains(one: OneMachine, candidate: Candidate, at: np.ndarray) -> np.ndarray:
    """(S,) energy that a step of the candidate from each of the samples `at` (S,) on explains."""
    T, b, _ = _normal(one, candidate, at)
    values, vectors = np.linalg.eigh(T)
    seen = values > _OPEN
    parts = np.einsum("sgh,sg->sh", vectors, b)
    return np.where(seen, np.square(parts) / np.where(seen, values, 1.0), 0.0).sum(axis=1)


def _normal(
    one: OneMachine, candidate: Candidate, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normal matrices (S, C, C), right sides (S, C) and scales (S, C) of steps, beside the one machine."""
    Q, left, B = one.Q[:, candidate.rows], one.left[:, candidate.rows], candidate.columns
    QB, BB, Be = (
        np.array([_after(x[a:b], y[a:b]) for a, b in zip(at, [*at[1:], len(B)], strict=True)])[::-1].cumsum(
            axis=0
        )[::-1]
        for x, y in ((Q, B), (B, B), (left[..., None], B))
    )
    scale = np.sqrt(np.einsum("sgg->sg", BB))
    scale = np.where(scale > 0, scale, 1.0)
    T = (BB - np.swapaxes(QB, 1, 2) @ QB) / scale[:, :, None] / scale[:, None, :]
    return T, Be[:, 0] / scale, scale


def _after(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(X, Y) products of columns x (m, R, X) and y (m, R, Y), summed."""
    return x.reshape(-1, x.shape[2]).T @ y.reshape(-1, y.shape[2])


def _first(one: OneMachine, candidate: Candidate, at: int) -> float | None:
    """The step of the candidate's first parameter; None where it is open."""
    T, b, scale = (x[0] for x in _normal(one, candidate, np.array([at])))
    values, vectors = np.linalg.eigh(T)
    seen = vectors[:, values > _OPEN]
    if np.linalg.norm(seen[0]) < 1 - EQUATIONS.estimable:
        return None
    return float(seen[0] / values[values > _OPEN] @ (seen.T @ b) / scale[0])


def _size(of: Balances, one: OneMachine, after: OneMachine) -> float:
    """Rms of what a step explains over the torque's rms, where that is most."""
    count = (of.samples.use[:, of.joints] > 0).sum(axis=0)
    explained = np.sqrt(np.square((one.left - after.left) / one.weight).sum(axis=0) / count)
    return float(np.max(explained / _levels(of)))


def _orthonormal(A: np.ndarray, scale: np.ndarray, least: float) -> np.ndarray:
    """(m, r) of the columns of A (m, C), each over its scale (C,), without directions that are open."""
    A = A / np.where(scale > 1e-12 * scale.max(initial=0.0), scale, np.inf)
    values, vectors = np.linalg.eigh(A.T @ A)
    seen = values > least * max(float(values[-1]), 1e-300)
    return A @ (vectors[:, seen] / np.sqrt(values[seen]))


def _defect(source: str, time: float, found: Change, channel: str, what: str) -> Defect:
    return Defect("doubtful", "change", channel,
                  f"{source}: from {round(time, 3):.13g} s on it is another machine than before: parameters "
                  f"of its own from there leave {max(100 * found.left, 1):.0f} % of the residual. {what}. "
                  "Cut the log there, and fit the parts apart")  # fmt: skip


def grown(found: Change, unit: str) -> str:
    """By how much, where that is known."""
    if found.first is None:
        return ""
    return f" ({abs(found.first):.2g} {unit} {'more' if found.first > 0 else 'less'})"
