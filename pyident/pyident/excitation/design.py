"""Motions scored by what they tell, and made smaller until all who rehearse them keep the limits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot, RobotError
from pyident.excitation.criterion import Along, Yardstick, along, independent, information, yardstick
from pyident.excitation.drawing import SHRINK, SMALLEST, Drawing, Task
from pyident.excitation.fourier import Family
from pyident.excitation.jury import Jury
from pyident.excitation.rehearsal import Rehearsal
from pyident.excitation.search import Best, Budget, best_of
from pyident.regression.regressor import regressor

_SEARCH = 0.8  # of the progress; the rest is the rehearsals'
_TRIED = 3  # offers that are rehearsed at most

Score = Callable[[Along], float]
Worth = Callable[[Experiment], float]
Progress = Callable[[float], None]


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
    raise RobotError(
        f"robot {task.robot.name}: no motion of {task.duration:g} s keeps its limits; does it keep them at "
        "rest in its zero pose, with its links apart and over the floor?"
    )


def informative(task: Task, drawing: Drawing, level: Yardstick) -> Score:
    """log det of the information of the base parameters."""
    drawn = [r for x in starts(drawing.family, 8) if (r := drawing.reference(x)) is not None]
    base = independent(np.sum([along(task.robot, level, r).gram for r in drawn], axis=0))
    return lambda found: information(found.gram, base)


def well_conditioned(task: Task, drawing: Drawing, level: Yardstick) -> Score:
    """Minus the logarithm of the condition number of the base regressor, in SI units and unweighted."""
    drawn = [r for x in starts(drawing.family, 8) if (r := drawing.reference(x)) is not None]
    met = [along(task.robot, level, r) for r in drawn]
    base = independent(np.sum([found.gram for found in met], axis=0))
    return lambda found: -float(np.log(np.linalg.cond(_triangle(task.robot, found, base))))


def _triangle(robot: Robot, found: Along, base: np.ndarray) -> np.ndarray:
    """(R, R) with the singular values of the equations of every sample, of R columns."""
    Phi = regressor(robot, found.motion).matrix[:, :, base]
    return np.asarray(np.linalg.qr(Phi.reshape(-1, len(base)), mode="r"))


def searched(
    drawing: Drawing, score: Score, level: Yardstick, budget: Budget, progress: Progress | None = None
) -> Best:
    """The numbers of the motion with the highest score along a reference that is followed exactly."""

    def judged(x: np.ndarray) -> float:
        reference = drawing.reference(x)
        return -np.inf if reference is None else score(along(drawing.task.robot, level, reference))

    return best_of(judged, starts(drawing.family, 12), budget, progress)


def designed(
    task: Task,
    drawing: Drawing,
    score: Score,
    level: Yardstick,
    rehearsal: Rehearsal,
    budget: Budget,
    progress: Progress | None = None,
) -> Design:
    """The motion with the highest score, made smaller until it and its rehearsals keep the limits.

    Raises RobotError where none does.
    """
    told = progress or (lambda _: None)
    best = searched(drawing, score, level, budget, lambda share: told(_SEARCH * share))
    reference = drawing.reference(best.x, 1 / task.rate)
    if reference is None:
        raise RobotError(f"robot {task.robot.name}: no motion was found that keeps the limits")
    offer = Offer(drawing.plan(reference), best)
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
    Raises RobotError where nobody may run any of them.
    """
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


def starts(family: Family, count: int) -> list[np.ndarray]:
    """Random members (size,) of the family, the same for the same count."""
    rng = np.random.default_rng(0)
    return [rng.standard_normal(family.size) for _ in range(count)]
