"""A motion that brings two rivals apart: searched along references, polished and chosen in simulation.

Along a reference that is followed exactly a motion is judged in milliseconds, and its period may be short or
long. What comes out of it is a start: how much of the robot's own multisine helps, what the loop makes of the
motion and what noise leaves on it, only the rivals' own noisy runs tell. By these the start is polished, and
so is the robot's own experiment; the better of the two is rehearsed first.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flexmodels.experiment import Experiment
from flexmodels.robot import RobotError
from pyident.excitation.criterion import Yardstick
from pyident.excitation.design import Design, Offer, Progress, Score, rehearsed, searched
from pyident.excitation.drawing import Drawing
from pyident.excitation.rehearsals.rehearsal import Rehearsal
from pyident.excitation.search import Best, Budget, best_of
from pyident.excitation.separation.contest import Contest
from pyident.excitation.separation.tuned import Tuned
from pyident.excitation.task import Task

WAVES = (0.0, 0.5, 1.0)  # shares of the multisine that are tried: it shows inertias and hides friction
REPEATS = (1, 2, 4)  # periods that fill a motion: slow ones reach far, quick ones turn back often
_SEEDS = (11, 12)  # of the noise under which motions are compared
_ALONG, _TUNED, _POLISHED = 0.25, 0.3, 0.25  # of the progress; the rest is the rehearsals'
_STEP = 0.2  # first step of a polish, of numbers of unit size

Drawn = Callable[[np.ndarray], Experiment | None]


@dataclass(frozen=True)
class Separation:
    """What a motion is to bring apart."""

    task: Task
    contest: Contest
    score: Score
    level: Yardstick

    def worth(self, plan: Experiment) -> float:
        """Standard deviations between the rivals in simulated logs."""
        return self.contest.sigmas(plan, _SEEDS)

    def designed(self, own: Rehearsal, budget: Budget, progress: Progress | None = None) -> Design:
        """Raises RobotError where no motion keeps the limits."""
        told = progress or (lambda _: None)
        drawings = [d for repeats in REPEATS if (d := _drawing(self.task, repeats)) is not None]
        offers = self._shaped(drawings, budget, told)
        tuned = Tuned.of(self.task, drawings[0])
        if tuned is not None and not any(offer.best.stopped for offer in offers):
            part, begun = _part(budget, _TUNED), _ALONG + _POLISHED
            offers += self._polished(tuned.plan, tuned.starts, part, _within(told, begun, _TUNED))
        if not offers:
            raise RobotError(f"robot {self.task.robot.name}: no motion was found that keeps the limits")
        offers.sort(key=lambda offer: -offer.best.score)
        done = _ALONG + _TUNED + _POLISHED
        spent = sum(offer.best.evaluations for offer in offers)
        offers = [replace(x, best=replace(x.best, evaluations=spent)) for x in offers]
        return rehearsed(
            self.task, offers, (own, *self.contest.rehearsals), _within(told, done, 1 - done), self.worth
        )

    def _shaped(self, drawings: list[Drawing], budget: Budget, told: Progress) -> list[Offer]:
        """Of Fourier series: the best of every period along its reference, and the best of them polished."""
        found: list[tuple[Drawing, Best]] = []
        share = _ALONG / len(drawings)
        for i, drawing in enumerate(drawings):
            part, progress = _part(budget, share), _within(told, i * share, share)
            along = searched(drawing, self.score, self.level, part, progress)
            if along.stopped:
                plan = self._drawn(drawing)(np.append(along.x, WAVES[-1]))
                return [] if plan is None else [Offer(plan, along)]
            waved = [np.append(along.x, wave) for wave in WAVES]
            found.append((drawing, self._best(self._drawn(drawing), waved, Budget(len(waved)))))
        drawing, first = max(found, key=lambda pair: pair[1].score)
        part, progress = _part(budget, _POLISHED), _within(told, _ALONG, _POLISHED)
        return self._polished(self._drawn(drawing), [first.x], part, progress)

    def _polished(
        self, drawn: Drawn, starts: list[np.ndarray], budget: Budget, progress: Progress
    ) -> list[Offer]:
        best = self._best(drawn, starts, budget, progress)
        plan = drawn(best.x)
        return [] if plan is None else [Offer(plan, best)]

    def _best(
        self, drawn: Drawn, starts: list[np.ndarray], budget: Budget, progress: Progress | None = None
    ) -> Best:
        def judged(z: np.ndarray) -> float:
            plan = drawn(z)
            return -np.inf if plan is None else self.worth(plan)

        return best_of(judged, starts, budget, progress, _STEP)

    def _drawn(self, drawing: Drawing) -> Drawn:
        """Of a series' numbers, with the share of the multisine at their end."""

        def drawn(z: np.ndarray) -> Experiment | None:
            reference = drawing.reference(z[:-1], 1 / self.task.rate)
            return None if reference is None else drawing.plan(reference, float(np.clip(z[-1], 0, 1)))

        return drawn


def _part(budget: Budget, share: float) -> Budget:
    """Of what a search may cost, without the rehearsals."""
    share /= _ALONG + _TUNED + _POLISHED
    return replace(
        budget, seconds=share * budget.seconds, evaluations=max(1, round(share * budget.evaluations))
    )


def _within(told: Progress, begun: float, share: float) -> Progress:
    return lambda part: told(begun + share * part)


def _drawing(task: Task, repeats: int) -> Drawing | None:
    """None where its approach takes too long for that many periods."""
    try:
        return Drawing(replace(task, repeats=repeats))
    except RobotError:
        return None
