"""Motions scored by what they tell, and made smaller until all who rehearse them keep the limits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import RobotError
from pyident.excitation.criterion import Along, Yardstick, along, independent, information, yardstick
from pyident.excitation.drawing import SHRINK, SMALLEST, Drawing, starts
from pyident.excitation.gradients.slopes import Setting
from pyident.excitation.gradients.smallest_condition import smallest_condition
from pyident.excitation.limits import where_it_begins
from pyident.excitation.rehearsals.jury import Jury
from pyident.excitation.rehearsals.rehearsal import Rehearsal, reference_of_plan
from pyident.excitation.rehearsals.violations import of_reference
from pyident.excitation.search import Best, Budget, best_of
from pyident.excitation.task import Task

_SEARCH = 0.8  # of the progress; the rest is the rehearsals'
_STARTS = 12  # random motions, of which a search takes the best first
_DRAWN = 8  # of them, that tell which columns are independent
_CONFINED, _FURTHER = 0.25, 1.25  # of a joint's range; and of the motion
_LESS = (1.0, 0.5, 0.25)  # of the spread that is asked for, one after the other until a motion is left
_TRIED = 3  # offers that are rehearsed at most

Score = Callable[[Along], float]
Worth = Callable[[Experiment], float]
Progress = Callable[[float], None]
Search = Callable[[Task, Drawing, Rehearsal, Budget, Progress], "Offer"]


@dataclass(frozen=True)
class Offer:
    """A motion before its rehearsals.

    best   the search that led to it
    """

    plan: Experiment
    best: Best


@dataclass(frozen=True)
class Design:
    """A plan that kept every limit in its rehearsals.

    offer       what it was before them;  scale: of the way from home that the rehearsals left
    binding     what would not let it be larger, empty where nothing was in its way
    rehearsed   how many other robots ran it, with parameters off by spread
    """

    plan: Experiment
    offer: Offer
    scale: float
    binding: str
    rehearsed: int
    spread: float


def measure(task: Task, drawing: Drawing, rehearsal: Rehearsal) -> Yardstick:
    """The noise's level along a first motion that the robot can run. Raises RobotError."""
    for x in starts(drawing.family, 20):
        reference = drawing.reference(x, 1 / task.rate)
        if reference is None:
            continue
        try:
            return yardstick(task.robot, rehearsal.log(drawing.plan(reference)), task.noise)
        except SimulationError:
            continue
    raise RobotError(no_motion(task))


def no_motion(task: Task) -> str:
    """Why there is none that keeps the limits, as far as it can be told."""
    return (
        f"robot {task.robot.name}: no motion of {task.duration:g} s keeps its limits. It begins "
        f"{where_it_begins(task.robot, task.limits)}; does it keep them at rest there, with its links apart "
        "and over the floor?"
    )


def informative(task: Task, drawing: Drawing, level: Yardstick) -> Score:
    """log det of the information of the base parameters."""
    drawn = [r for x in starts(drawing.family, _DRAWN) if (r := drawing.reference(x)) is not None]
    base = independent(np.sum([along(task.robot, level, r).gram for r in drawn], axis=0))
    return lambda found: information(found.gram, base)


def most_informative(
    task: Task, drawing: Drawing, rehearsal: Rehearsal, budget: Budget, progress: Progress
) -> Offer:
    """Of the base parameters, in the noise of the sensors. Raises RobotError."""
    level = measure(task, drawing, rehearsal)
    best = searched(drawing, informative(task, drawing, level), level, budget, progress)
    reference = drawing.reference(best.x, 1 / task.rate)
    if reference is None:
        raise RobotError(f"robot {task.robot.name}: no motion was found that keeps the limits")
    return Offer(drawing.plan(reference), best)


def best_conditioned(
    task: Task, drawing: Drawing, rehearsal: Rehearsal, budget: Budget, progress: Progress
) -> Offer:
    """With the smallest condition number of the base regressor, in SI units and unweighted.

    Raises RobotError.
    """
    first = drawing.starts(_STARTS)
    if not first:
        raise RobotError(no_motion(task))
    whole = Setting(
        drawing, drawing.family.times(drawing.coarse), np.arange(len(task.robot.linear_parameters))
    )
    tried = [whole.samples(whole.motion(start)).matrix for start in first[:_DRAWN]]
    base = independent(np.sum([np.einsum("nrp,nrq->pq", Phi, Phi) for Phi in tried], axis=0))
    best = smallest_condition(replace(whole, columns=base), first, budget, progress)
    return Offer(drawing.plan(drawing.family.motion(best.x, 1 / task.rate)), best)


def searched(
    drawing: Drawing, score: Score, level: Yardstick, budget: Budget, progress: Progress | None = None
) -> Best:
    """The numbers of the motion with the highest score along a reference that is followed exactly."""

    def judged(x: np.ndarray) -> float:
        reference = drawing.reference(x)
        return -np.inf if reference is None else score(along(drawing.task.robot, level, reference))

    return best_of(judged, starts(drawing.family, _STARTS), budget, progress)


def designed(
    task: Task,
    drawing: Drawing,
    search: Search,
    rehearsal: Rehearsal,
    budget: Budget,
    progress: Progress | None = None,
) -> Design:
    """The motion that a search offers, made smaller until it and its rehearsals keep the limits.

    Raises RobotError where none does.
    """
    told = progress or (lambda _: None)
    offer = search(task, drawing, rehearsal, budget, lambda share: told(_SEARCH * share))
    return rehearsed(task, [offer], (rehearsal,), lambda share: told(_SEARCH + (1 - _SEARCH) * share))


def rehearsed(
    task: Task,
    offers: Sequence[Offer],
    rehearsals: Sequence[Rehearsal],
    progress: Progress,
    worth: Worth | None = None,
) -> Design:
    """The offer that is worth most at the size that its rehearsals leave it, the first ones first.

    rehearsals   of the robot, and of its rivals
    Where robots so far off as asked may run none of them, others rehearse that are less far off.
    Raises RobotError where nobody may run any.
    """
    refused: RobotError | None = None
    for part in _LESS:
        less = replace(task, spread=part * task.spread)
        try:
            return _best_rehearsed(less, offers, rehearsals, progress, worth)
        except RobotError as error:
            refused = error
    raise refused or RobotError("no spread to rehearse with")


def _best_rehearsed(
    task: Task,
    offers: Sequence[Offer],
    rehearsals: Sequence[Rehearsal],
    progress: Progress,
    worth: Worth | None,
) -> Design:
    """The offer that is worth most. Raises RobotError."""
    jury = Jury(task.robot, task.limits, task.geometry, rehearsals, task.spread)
    best, most, refused = None, -np.inf, None
    for offer in offers[:_TRIED]:
        if worth is not None and best is not None and worth(offer.plan) <= most:
            break
        try:
            found = _as_large_as_allowed(task, offer, jury, progress)
        except RobotError as error:
            refused = error
            continue
        value = 0.0 if worth is None else worth(found.plan)
        if value > most:
            best, most = found, value
    if best is None:
        raise refused or RobotError(f"robot {task.robot.name}: no motion was found that keeps the limits")
    return best


def nearer(task: Task, design: Design) -> tuple[str, ...]:
    """A sentence where robots as far off as asked could not rehearse it."""
    if design.spread >= task.spread:
        return ()
    return (
        f"with parameters {100 * task.spread:g} % off the robot's loop keeps no limits: this "
        f"one was rehearsed with {100 * design.spread:.3g} % (plan check --spread {design.spread:.3g})",
    )


def confined(task: Task, plan: Experiment) -> tuple[str, ...]:
    """A sentence where joints keep to a small part of their range because links would touch."""
    span = task.limits.upper - task.limits.lower
    share = np.ptp(plan.reference, axis=0) / np.where(span > 0, span, np.inf)
    small = [k for k in np.flatnonzero(share < _CONFINED) if np.isfinite(span[k])]
    further = task.limits.home + _FURTHER * (plan.reference - task.limits.home)
    motion = reference_of_plan(replace(plan, reference=further))
    broken = of_reference(task.robot, task.limits, task.geometry, motion) if small else []
    near = next((violation for violation in broken if violation.what == "distance"), None)
    if near is None:
        return ()
    named = ", ".join(f"joint{k + 1} to {100 * share[k]:.0f} %" for k in small)
    return (
        f"the motion keeps to a small part of what the joints may do ({named} of the range), as {near.where} "
        "would touch: give the radius of the links, if they are thinner, or leave the floor out",
    )


def _as_large_as_allowed(task: Task, offer: Offer, jury: Jury, progress: Progress) -> Design:
    scale, home, binding = 1.0, task.limits.home, ""
    while scale > SMALLEST:
        progress(float(np.log(scale) / np.log(SMALLEST)))
        plan = replace(
            offer.plan,
            reference=home + scale * (offer.plan.reference - home),
            feedforward=scale * offer.plan.feedforward,
        )
        if not (broken := jury.broken(plan)):
            return Design(plan, offer, scale, binding, len(jury.others), task.spread)
        scale, binding = scale * SHRINK, broken
    raise RobotError(
        f"robot {task.robot.name}: not even a small motion keeps a limit of {binding} with parameters "
        f"{100 * task.spread:g} % off; give a smaller spread, or the robot a loop that allows for it"
    )
