"""From logs to the search of what a model lacks: a fit, its replicas, and what every candidate explains.

Positions that all come late are moved back first, and torques are taken as before a common low pass.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.alignment import NOTHING, Alignment
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.floor_shares import worth_little
from pyident.diagnosis.base.residual_over_floor import examine
from pyident.diagnosis.base.ringing_hinges import with_ringing_matched
from pyident.diagnosis.base.setting import Setting, set_up, steadied, unbiased, workers_of
from pyident.diagnosis.drives.bending import links_swing
from pyident.diagnosis.misaligned import alignment_of
from pyident.diagnosis.search.search import Search, search_of
from pyident.estimation.identify import relative_error
from pyident.logs.log import Log, LogError
from pyident.refinement.instruments.stand_in import driven
from pyident.rules.rules import RULES, Rules
from pyident.simulation.denoised import unfiltered, within, without_filter
from pyident.simulation.simulator import OpenPool, Workers

Progress = Callable[[float], None]


class UnsimulatedFitError(LogError):
    """The replicas of a fit serve nothing."""


def searched(
    robot: Robot,
    logs: Sequence[Log],
    open_pool: OpenPool,
    progress: Progress = lambda _: None,
    rules: Rules = RULES,
) -> Search:
    """The fitted robot's residual in `logs`, its replicas' and every candidate. Raises LogError.

    A fit that cannot be simulated is damped until it can, first the one by instruments, then the regression,
    whose bias stays; at last it is fitted through the filter of the robot's file, without which all else is,
    or without that of joints that bend under an unknown loop, who else need it.
    Where no simulation follows the logs, the sensors' noise alone tells where something is missing.
    Positions that all come late are moved back first, and torques are taken as before a common low pass.
    """
    plain, progress = unfiltered(robot, logs), _rising(progress)
    bare = without_filter(robot, logs)
    for asked in [plain, *(other for other in (robot, bare) if other != plain)]:
        try:
            return _aligned(asked, logs, open_pool, progress, rules)
        except UnsimulatedFitError as error:
            failed = str(error)
    return _by_noise(replace(set_up(plain, logs, rules), unfollowed=failed), open_pool, progress)


def part_of(progress: Progress, start: float, width: float = 0.05) -> Progress:
    """Progress of what takes a share `width` of the whole, after `start` of it."""
    return lambda share: progress(start + width * share)


def _rising(progress: Progress) -> Progress:
    """Progress that waits, where something is begun again, until that is as far."""
    told = 0.0

    def report(done: float) -> None:
        nonlocal told
        if done > told:
            told = done
            progress(done)

    return report


def _by_noise(setting: Setting, open_pool: OpenPool, progress: Progress) -> Search:
    """The search over a floor of the sensors' noise alone: it says where the equations fail, and no name."""
    with workers_of(setting, open_pool) as workers:
        search = search_of(examine(setting, workers, progress))
    if not search.stands_out:
        raise UnsimulatedFitError(setting.unfollowed)
    return search


def _aligned(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress, rules: Rules
) -> Search:
    setting = set_up(robot, logs, rules)
    once = setting.simulates or len(robot.joints) == 1
    search = _searched(setting, open_pool, progress if once else part_of(progress, 0.0, 0.6))
    found = alignment_of(search.examination)
    if found.needed:
        heard = within(robot, found.band)
        moved = set_up(heard, found.of_all(robot, logs), rules, alignment=found)
        in_time = _searched(moved, open_pool, part_of(progress, 0.6, 0.4))
        only_late = found == Alignment(found.late)
        search = search if only_late and links_swing(search, in_time) else in_time
    progress(1.0)
    return search


def _searched(setting: Setting, open_pool: OpenPool, progress: Progress) -> Search:
    progress(0.05)
    why, moved = "its replicas leave most of the torque unexplained", None
    with workers_of(setting, open_pool) as workers:
        for adjusted in _adjustments(setting, workers):
            try:
                found = adjusted()
                moved = _on_one_clock(setting, found.late)
                if moved is not None:
                    break
                progress(0.2)
                search = search_of(examine(found, workers, part_of(progress, 0.2, 0.8)))
            except SimulationError as error:
                why = str(error)
                continue
            if not (setting.simulates and worth_little(search.examination)):
                return search
    if moved is not None:
        return _searched(moved, open_pool, progress)
    raise UnsimulatedFitError(
        f"{setting.logs[0].source}: the fit of robot {setting.robot.name} to it cannot be simulated "
        f"({why}); check the units and signs of its columns, and that the robot file has the right "
        "joints; else the model lacks something large, such as a base or a link that bends"
    )


def _on_one_clock(setting: Setting, late: float) -> Setting | None:
    """The setting whose positions were moved by the time that a fit finds them late, if that leaves less.

    None where nothing is to be moved. A loop's answer to its encoders' noise looks like a delay, too.
    """
    if not late or setting.alignment.needed:
        return None
    clock = Alignment.by_clock(setting.robot, late, setting.period)
    logs = clock.of_all(setting.robot, setting.logs)
    mended = set_up(clock.taken(setting.robot), logs, setting.rules, alignment=clock)
    left, before = (relative_error(s.reduced, s.solution.p, len(s.robot.joints)) for s in (mended, setting))
    return mended if left["all"] < before["all"] else None


def _adjustments(setting: Setting, workers: Workers) -> Iterator[Callable[[], Setting]]:
    """What makes the setting one whose replicas serve, the best first.

    A controller that stands in for a loop bends a fit by itself: only in a known one is that fit steadied.
    """
    bent = partial(steadied, setting)
    try:
        free = unbiased(setting, workers)
    except SimulationError:
        yield bent
        return
    yield partial(with_ringing_matched, free, workers)
    if driven(setting.robot):
        yield partial(steadied, free)
    yield bent


def alignment_in(robot: Robot, logs: Sequence[Log], open_pool: OpenPool, rules: Rules = RULES) -> Alignment:
    """What keeps positions and torques of logs apart, as a search would find first. Raises LogError."""
    setting = set_up(unfiltered(robot, logs), logs, rules)
    if setting.simulates and driven(setting.robot):
        return NOTHING
    with workers_of(setting, open_pool) as workers:
        free = unbiased(setting, workers)
        if setting.simulates:
            moved = _on_one_clock(setting, free.late)
            return NOTHING if moved is None else moved.alignment
        return alignment_of(examine(free, workers, lambda _: None, lambda *_: []))


def weighed_anew(
    search: Search, named: Sequence[Candidate], open_pool: OpenPool, progress: Progress
) -> Search:
    """The search with floors that are raised by what a robot lacks beside what was named. Raises LogError."""
    setting = search.examination.setting
    with workers_of(setting, open_pool) as workers:
        return search_of(examine(setting, workers, progress, beside=named))


def put_right(setting: Setting, further: Alignment, open_pool: OpenPool, progress: Progress) -> Search:
    """The search in logs of which more is put right: a delay of all, what single torques went through, or
    that all are held.
    """
    logs = further.of_all(setting.robot, setting.logs)
    whole = setting.alignment.then(further)
    mended = set_up(further.taken(setting.robot), logs, setting.rules, setting.estimator, whole)
    return _searched(mended, open_pool, progress)
