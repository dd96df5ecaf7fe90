"""Whether another sign, unit, zero or order of the channels explains a log far better than its own."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import joint_name, torque_of
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.checks.balances import Balances, balances, solved
from pyident.checks.defect import Defect
from pyident.checks.transformations import Transformation, transformations
from pyident.kinematics.structure import StructureError
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.log_checks import LOG_CHECKS

_ROWS = 400  # samples on which the many are tried; the best is judged on all
_JUDGED = 3
_WORSE = 1.2  # times what was left: more is no better
_SCALES = ("unit", "ratio")  # kinds of changes under which parameters may fit that are not told otherwise
_STRETCHES = 8  # of a log, of which every other one explains those between
_PARTS, _KNOWN = 8, 0.3  # of a log that nothing explains as a whole; share of them that explain each other
_EXPLAINED = 0.1  # of a torque, that may be left of it then


@dataclass(frozen=True)
class Misfit:
    """What one set of parameters leaves of all torques, as a share of their variances, per joint.

    each   joint (from 0) -> its own
    """

    each: Mapping[int, float]

    @property
    def share(self) -> float:
        return float(np.mean(list(self.each.values()))) if self.each else 0.0

    @property
    def material(self) -> bool:
        return self.share > LOG_CHECKS.material**2


def misfit(of: Balances, torque: np.ndarray | None = None, among: Sequence[int] | None = None) -> Misfit:
    """With torques (joints, joints) times the logged ones, over the joints `among` (from 0) that move."""
    tau = of.torque if torque is None else of.torque @ torque.T
    among = of.joints if among is None else among
    joints = [k for k in of.joints if k in among and of.variance(k, tau[:, k]) > 0]
    if not joints:
        return Misfit({})
    systems = _systems(of, tau, joints)
    return Misfit(_left(systems, _best(systems)))


_System = tuple[np.ndarray, np.ndarray, float]  # AᵀA (P, P), Aᵀy (P,), yᵀy of a joint, over its variance


def _systems(of: Balances, tau: np.ndarray, joints: Sequence[int]) -> dict[int, _System]:
    """Of joints (from 0) under torques (M, joints)."""
    found = {}
    for k in joints:
        variance = max(of.variance(k, tau[:, k]), 1e-300)
        b, yy = of.right(k, tau[:, k : k + 1])
        found[k] = of.normal[k] / variance, b[:, 0] / variance, float(yy[0]) / variance
    return found


def _best(systems: Mapping[int, _System]) -> np.ndarray:
    """(P,) parameters that leave least of all."""
    normal = np.sum([A for A, _, _ in systems.values()], axis=0)
    return solved(normal, np.sum([b for _, b, _ in systems.values()], axis=0))[0]


def _left(systems: Mapping[int, _System], p: np.ndarray) -> dict[int, float]:
    """What parameters p (P,) leave of each."""
    return {k: max(yy - 2 * float(b @ p) + float(p @ A @ p), 0.0) for k, (A, b, yy) in systems.items()}


@dataclass(frozen=True)
class Better:
    """The change of the channels that explains a log best; shares of the torques left with and without."""

    change: Transformation
    left: float
    now: float


def best_change(of: Balances, placed: bool = True) -> Better | None:
    """The change that explains a log far better than its channels as they are, None where there is none.

    placed   whether something says which columns are of which joint; else hoses do not excuse their order
    """
    now = misfit(of)
    if not now.material or len(of.samples.at) * len(of.joints) < EQUATIONS.per_parameter * len(of.columns):
        return None
    few = of.samples.every(max(1, len(of.samples.at) // _ROWS))
    looped = bool(of.samples.robot.closures)  # then other positions are out of reach, and slow to find so
    resting = [k for k in range(of.torque.shape[1]) if k not in of.joints]  # holding a brake, or anything
    changes = [
        change
        for change in transformations(of.samples.robot, of.samples.q)
        if not (looped and change.moves) and not any(map(change.exchanges, resting))
    ]
    start = balances(few)
    tried = [(*_shares(_misfits(start, change)), i, change) for i, change in enumerate(changes)]
    tried.sort(key=lambda shares: (shares[0] - shares[1], shares[2]))
    judged = [(_misfits(of, change), i, change) for _, _, i, change in tried[:_JUDGED]]
    best = [(*_shares(misfits), i, misfits, change) for misfits, i, change in judged]
    left, now_so, _, misfits, change = min(best, key=lambda shares: (shares[0] - shares[1], shares[2]))
    guessed = change.kind == "order" and not placed
    far = _far(left, now_so) and (guessed or _far(*_shares(_misfits(of, change, hoses=True))))
    far = far and not _suits_one(*misfits, change)
    if change.kind in _SCALES:
        far = far and _far(*_across(of, change))
    return Better(change, left, now_so) if far else None


def _across(of: Balances, change: Transformation) -> tuple[float, float]:
    """Shares of the torques that are left with a change and without it, where parameters of every other
    stretch of a log explain those between: another scale lets parameters fit that the log does not tell.
    """
    other = _changed(of, change)
    tau = of.torque @ change.torque.T
    joints = _in_both(of, other, tau)
    return _left_between(other, tau, joints), _left_between(of, of.torque, joints)


def _changed(of: Balances, change: Transformation) -> Balances:
    """Raises StructureError for a loop that does not close so."""
    return balances(of.samples.moved(change.motion, change.offset)) if change.moves else of


def _in_both(of: Balances, other: Balances, tau: np.ndarray) -> list[int]:
    """Joints (from 0) that move in both, of the other under torques (M, joints) that tell something."""
    return [k for k in of.joints if k in other.joints and other.variance(k, tau[:, k]) > 0]


def _left_between(of: Balances, tau: np.ndarray, joints: Sequence[int]) -> float:
    """Of torques (M, joints), on average over joints (from 0)."""
    even = np.arange(len(of.samples.at)) * _STRETCHES // len(of.samples.at) % 2 == 0
    a, b = (_systems(of.within(part), tau, joints) for part in (even, ~even))
    there, back = _left(b, _best(a)), _left(a, _best(b))
    return float(np.mean([*there.values(), *back.values()]))


def _far(left: float, now: float) -> bool:
    return left < LOG_CHECKS.better * now and now - left > LOG_CHECKS.material**2


def better_channels(of: Balances, source: str) -> Iterator[Defect]:
    """The transformation that explains the log best, where it explains it far better."""
    if (best := best_change(of)) is not None:
        gross = best.left < LOG_CHECKS.far_better * best.now
        yield Defect(
            "gross" if gross else "doubtful",
            best.change.kind,
            best.change.channel,
            f"{source}: {best.change.mend} ({100 * np.sqrt(best.left):.2g} % of the torques are left, not "
            f"{100 * np.sqrt(best.now):.2g} %)",
        )


def unexplained(of: Balances, source: str) -> Iterator[Defect]:
    """Torques that no parameters at all connect with the motion, nor a spring or a hose at the joint."""
    left = {k: of.left_beside(k, of.hose(k)) for k in of.joints}
    lost = [k for k, energy in left.items() if _lost(of, k, energy)]
    if lost and len(lost) == len(left):
        if (strange := _strange_part(of)) is not None:
            begin, end = strange
            yield Defect("doubtful", "unrelated", "", f"{source}: the motion explains the torques but for "
                         f"those from {begin:.3g} to {end:.3g} s after its start: was something touched or "
                         "taken up there?")  # fmt: skip
            return
        yield Defect("gross", "unrelated", "", f"{source}: the motion explains less than half of every "
                                               "torque, "
                     f"whatever the robot's masses and frictions are; positions and torques are not of the "
                     "same "
                     f"recording, or torques were not measured")  # fmt: skip
        return
    for k in lost:
        share = left[k] / max(of.variance(k), 1e-300)
        yield Defect("doubtful", "unrelated", torque_of(k + 1), f"{source}: {100 * share:.0f} % of "
                     f"{torque_of(k + 1)} is nothing that its motion explains; check that it is this joint's "
                     f"torque")  # fmt: skip


def _strange_part(of: Balances) -> tuple[float, float] | None:
    """Begin and end [s] of the part of a log that differs from the rest, where parts of it explain others."""
    own, count = of.samples, len(of.samples.at)
    edges = np.linspace(0, count, _PARTS + 1).astype(int)
    number = np.searchsorted(edges, np.arange(count), side="right") - 1
    left = _left_by_neighbours([of.within(number == i) for i in range(_PARTS)], of.joints)
    explained = left < _EXPLAINED
    best = int(np.argmax(explained.sum(axis=1)))
    odd = np.flatnonzero(~explained[best])
    if not len(odd) or explained[best].sum() <= max(2, _KNOWN * _PARTS):  # a pair always explains itself
        return None
    return own.period * int(own.at[edges[odd[0]]]), own.period * int(own.at[edges[odd[-1] + 1] - 1])


def _left_by_neighbours(parts: Sequence[Balances], joints: Sequence[int]) -> np.ndarray:
    """(parts - 1, parts) shares of torques that parameters of two neighbours leave of each, over joints."""
    shares = np.zeros((len(parts) - 1, len(parts)))
    for k in joints:
        normal = np.array([part.normal[k] for part in parts])
        rights = [part.right(k, part.torque[:, k : k + 1]) for part in parts]
        right, energy = np.array([b[:, 0] for b, _ in rights]), np.array([float(yy[0]) for _, yy in rights])
        whole = np.array([max(part.variance(k), 1e-300) for part in parts]) * len(joints)
        for i in range(len(shares)):
            p = solved(normal[i : i + 2].sum(axis=0), right[i : i + 2].sum(axis=0))[0]
            shares[i] += (energy - 2 * right @ p + normal @ p @ p) / whole
    return shares


def constants(of: Balances, robot: Robot, source: str) -> Iterator[Defect]:
    """Torques that only a constant connects with the motion, which the robot file has no place for.

    of: with a constant at every joint
    """
    for k in of.joints:
        name, torque = parameter_name(k + 1, "offset", "offset"), of.torque[:, k : k + 1]
        if name in robot.parameters or not _lost(of, k, float(of.left(k, torque, without=name)[0])):
            continue
        value = solved(of.normal[k], of.right(k, torque)[0])[0][of.columns.index(name), 0]
        yield Defect("doubtful", "offset", torque_of(k + 1),
                     f"{source}: {torque_of(k + 1)} holds a constant of {value:.3g} that no motion explains "
                     f"and the model has no place for; take it out of the column, or add effect offset at "
                     f"{joint_name(k + 1)}")  # fmt: skip


def _lost(of: Balances, k: int, left: float) -> bool:
    """Whether that is most of a torque. Of a weight that a slide only holds, the variation may be noise."""
    torque = of.torque[of.samples.use[:, k] > 0, k]
    whole = float(np.square(torque).sum())
    return left > max(LOG_CHECKS.unexplained * of.variance(k), LOG_CHECKS.material**2 * whole)


def _suits_one(after: Misfit, before: Misfit, change: Transformation) -> bool:
    """Whether a change only suits one joint, of which one that hardly moves tells too little: the joints that
    it is about are explained less with it, or all others than that one.
    """
    gains = {k: before.each[k] - left for k, left in after.each.items()}
    most = max(gains, key=lambda k: gains[k])
    parts = ([k for k in gains if k in change.joints], [k for k in gains if k != most])
    return any(
        sum(after.each[k] for k in part) > _WORSE * sum(before.each[k] for k in part) for part in parts
    )


def _shares(misfits: tuple[Misfit, Misfit]) -> tuple[float, float]:
    """Left with a change and without it, as of `_misfits`."""
    after, before = misfits
    return (after.share, before.share) if after.each else (float("inf"), 0.0)


def _misfits(of: Balances, change: Transformation, hoses: bool = False) -> tuple[Misfit, Misfit]:
    """With the change and without it, both over the joints that move either way; none where it cannot be.

    Otherwise a change that brings a joint to rest would be better by leaving out what is hard to explain.

    hoses   with a hose at every joint: what that explains, too, asks for no other channels
    """
    try:
        other = _changed(of, change)
    except StructureError:
        return Misfit({}), Misfit({})
    if hoses:
        other, of = other.beside_hoses, of.beside_hoses
    tau = of.torque @ change.torque.T
    both = _in_both(of, other, tau)
    return misfit(other, change.torque, both), misfit(of, None, both)
