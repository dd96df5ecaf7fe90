"""Which physical effect a model lacks, judged by its logs: a name, several names, none we know, or nothing.

The model is fitted; replicas of it show what the method itself leaves. What the data leave beyond that is put
to every effect of the catalogue at every joint. An effect is named only if nothing in the replicas comes near
its gain, if the gain matters, if it holds on logs that were not used, and if, all named together, most of
what exceeds the floor is gone. Else the verdict is `unexplained` or `nothing_detectable`.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.diagnosis.another_state import fitted_apart
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.standing_out import unsettled
from pyident.diagnosis.conclusion import conclusion
from pyident.diagnosis.drives.bending import about_bends, swinging
from pyident.diagnosis.friction_by_log import friction_by_log
from pyident.diagnosis.next_steps import with_dependences, with_experiments, with_revealing
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.rounds.asked import selected
from pyident.diagnosis.rounds.in_time import in_time
from pyident.diagnosis.rounds.laws_that_follow import with_laws_that_follow
from pyident.diagnosis.rounds.weighed import weighed
from pyident.diagnosis.rounds.with_law import beside_its_replicas
from pyident.diagnosis.search.found import Found, Step
from pyident.diagnosis.search.held_out import HeldOut, held_out
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.search.selection import Selection
from pyident.diagnosis.searched import part_of, searched
from pyident.logs.log import Log
from pyident.regression.descriptions import DELAY, DRIVE, description_names
from pyident.rules.rules import RULES, Rules
from pyident.simulation.denoised import unfiltered
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]
_ALONG = "no loop is simulated: replicas go along the measured motion, with the sensors' noise alone"
_NO_FILTER = "behind the low pass of all signals no simulation of a fit followed the logs: it was left out"


def diagnose(
    robot: Robot,
    logs: Sequence[Log],
    open_pool: OpenPool,
    heldout: Sequence[Log] = (),
    progress: Progress = lambda _: None,
    draft: bool = False,
    rules: Rules = RULES,
) -> Diagnosis:
    """What `robot` lacks in `logs`; its own dynamic parameters are never used.

    open_pool   gives processes that hold a robot's FMU (pyident.simulation.fmu_runs.FmuRuns)
    heldout        logs on which the findings must hold
    draft          look for a formula where no law explains the residual
    rules          every threshold
    An interrupt (Ctrl-C) after the search gives what is known by then. Raises LogError.
    """
    most = 0.7 if robot.controller else 0.5  # of the time; where nothing is simulated, the search is short
    search = searched(robot, logs, open_pool, part_of(progress, 0.0, most), rules)
    search, found = _from_columns(
        search.resting_on(()), heldout, open_pool, part_of(progress, most, 0.85 - most)
    )
    if search.examination.setting.unfollowed:
        progress(1.0)
        return found
    if left_out(unfiltered(robot, logs), search.robot):
        found = replace(found, notes=(_NO_FILTER, *found.notes))
    steps: list[tuple[str, Callable[[Diagnosis], Diagnosis]]] = [
        ("what the residual depends on", lambda d: _with_leads(search, d, open_pool, draft)),
    ]
    if search.examination.setting.simulates:
        steps += [
            (
                "motions that separate",
                lambda d: with_experiments(search, d, open_pool, part_of(progress, 0.85)),
            ),
            ("motions that show", lambda d: with_revealing(search, d, open_pool, part_of(progress, 0.95))),
        ]
    else:
        found = replace(found, notes=(_ALONG, *found.notes))
    found = _as_far_as(found, steps)
    progress(1.0)
    return found


def left_out(asked: Robot, judged: Robot) -> bool:
    """Whether a filter was left out through which the robot was asked first."""
    return asked.settings.processing.filters and not judged.settings.processing.filters


def servo_delay_in(
    robot: Robot,
    logs: Sequence[Log],
    open_pool: OpenPool,
    heldout: Sequence[Log] = (),
    progress: Progress = lambda _: None,
    rules: Rules = RULES,
) -> float:
    """Time [s] by which a servo answers later than the robot file says, beside the laws that explain most.

    0 where the logs do not tell. The others as in `diagnose`. Raises LogError.
    """
    search = searched(robot, logs, open_pool, progress, rules).resting_on(())
    delays = [Candidate(DELAY, k) for k, _ in robot.numbered if DELAY in description_names(robot, k)]
    if search.examination.setting.unfollowed or not delays:
        return 0.0
    given = [Step((Found(c, search.gain_of(c), 0.0, 1.0),), 1.0, ()) for c in delays]
    selection = selected(search, held_out(search, heldout), given)
    beside = search.resting_on([c for c in selection.candidates if c not in delays])
    told = [beside.gain_of(c) for c in delays]
    sooner, precision = np.array([[g.coefficients[0], g.std[0] ** -2] for g in told]).T
    mean = float(sooner @ precision / precision.sum())
    return -mean if abs(mean) > rules.search.chance * precision.sum() ** -0.5 else 0.0


def _as_far_as(found: Diagnosis, steps: Sequence[tuple[str, Callable[[Diagnosis], Diagnosis]]]) -> Diagnosis:
    """The diagnosis after all steps, or after those done when somebody interrupts: its verdict stands."""
    for number, (_, step) in enumerate(steps):
        try:
            found = step(found)
        except KeyboardInterrupt:
            left = ", ".join(name for name, _ in steps[number:])
            return replace(found, notes=(*found.notes, f"interrupted; not looked at: {left}"))
    return found


def _with_leads(search: Search, found: Diagnosis, open_pool: OpenPool, draft: bool) -> Diagnosis:
    return with_dependences(search, found, open_pool, draft) if found.verdict == "unexplained" else found


def concluded(search: Search, open_pool: OpenPool, heldout: Sequence[Log] = ()) -> Diagnosis:
    """What a search comes to. heldout: logs on which the findings must hold. Raises LogError."""
    return _from_columns(search.resting_on(()), heldout, open_pool)[1]


def _from_columns(
    search: Search, heldout: Sequence[Log], open_pool: OpenPool, progress: Progress = lambda _: None
) -> tuple[Search, Diagnosis]:
    """What the laws come to, and the search that says so: that in which logs have their own friction,
    where laws without it leave much more.
    """
    if search.examination.setting.unfollowed:
        following = with_laws_that_follow(search, heldout, open_pool, progress)
        if following is None:
            return search, _unnamed(search, heldout)
        search, held, selection = following
        return search, conclusion(search, selection, held, heldout)
    asked = in_time(search, heldout, open_pool, part_of(progress, 0.0, 0.5))
    asked = weighed(asked, heldout, open_pool, part_of(progress, 0.5, 0.15))
    search, held, selection = beside_its_replicas(asked, open_pool, part_of(progress, 0.65, 0.15))
    search, selection = _about_bends(search, held, selection)
    progress(0.8)
    beside = search.resting_on(selection.candidates)
    by_log = friction_by_log(search, beside.chosen) if unsettled(search.examination, beside.base) else None
    if by_log is not None:
        again, rows = selected(by_log.search, held), [k - 1 for k in by_log.joints]
        after = by_log.search.resting_on(again.candidates).remaining_on(rows)
        if after <= (1 - search.rules.explained[0]) * beside.remaining_on(rows):
            found = conclusion(by_log.search, again, held, heldout)
            named = search.resting_on(again.candidates)
            note, said = by_log.note(named), f"{by_log.sentence(named)} {found.sentence}"
            return by_log.search, replace(found, sentence=said, notes=(note, *found.notes))
    progress(0.9)
    return search, conclusion(search, selection, held, heldout)


def _unnamed(search: Search, heldout: Sequence[Log]) -> Diagnosis:
    """Where no simulation of a fit follows the logs, so that nothing tells what it leaves by itself."""
    found = conclusion(search, Selection((), search.step(), {}), held_out(search, heldout), heldout)
    worst = max((p for p in found.places if p.state == "unexplained"), key=lambda p: p.over_floor[1])
    said = (
        "Something large is missing or wrong: no simulation of the fitted model follows these logs, nor with "
        "the laws that explain most, so that no effect can be named. Most stands out of the noise at "
        f"{worst.joint}, {worst.balance} side."
    )
    return replace(found, sentence=said + fitted_apart(search.examination.setting))


def _about_bends(search: Search, held: HeldOut, selection: Selection) -> tuple[Search, Selection]:
    """What laws and errors come to about drives that bend far, where that names one and leaves far less, or
    fewer names leave no more.
    """
    beside = search.resting_on(selection.candidates)
    bent = about_bends(search) if unsettled(search.examination, beside.base) else None
    if bent is None:
        return search, selection
    again = selected(bent, held, swinging(bent, held))
    after = bent.resting_on(again.candidates).lacking.sum()
    fewer = len(again.steps) < len(selection.steps)
    less = after <= (1.0 if fewer else 1 - search.rules.explained[0]) * beside.lacking.sum()
    names = any(step.best.candidate.effect == DRIVE for step in again.steps)
    return (bent, again) if less and names else (search, selection)
