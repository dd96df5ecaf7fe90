"""The default estimator: instrumental variables from a simulated model, its own bias taken away.

The model found so far is simulated over each log's inputs. Its signals have no noise, so Φ of them is the
instrument (Janot, Vandanjon and Gautier 2014); and what its equations do not fulfil is the doing of samples
and means, not of noise, so that this residual is subtracted from the log's (indirect inference, Gourieroux et
al. 1993). At the fixed point log and simulation agree in every sum that the instruments take.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.conditioning.alignment import Alignment
from pyident.estimation.base_parameters import base_parameters, hardly_told
from pyident.estimation.identify import (
    Identified,
    disagreements,
    identified,
    impossible,
    near,
    without_intervals,
)
from pyident.estimation.slow_rest import slow_rest
from pyident.logs.log import Log
from pyident.refinement.in_motion import Rest
from pyident.refinement.instruments.fixed_point import FixedPoint
from pyident.refinement.instruments.following import Followers
from pyident.refinement.instruments.instrumental_covariance import (
    ringing,
    with_covariance,
    without_intervals_of,
)
from pyident.refinement.instruments.missed import NotFollowedError
from pyident.refinement.instruments.one_round import Round, next_round
from pyident.refinement.instruments.positions_late import Late, positions_late
from pyident.refinement.instruments.simulated_rows import Repeated, in_memory
from pyident.refinement.instruments.stand_in import driven, smoothed
from pyident.refinement.instruments.starts import Begun, begun, nearest
from pyident.regression.loads.bodies import reads_load
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.replica import Repeat, repeats
from pyident.simulation.simulator import OpenPool, Workers

NAME = "instrumental variables with a simulated model"
START = "instrumental variables with filtered signals"
_ROUNDS = 8
_NEAR = 3  # round from which on the steps are Newton's: there the simulation's own columns are measured
_SETTLED = 0.2  # of a standard deviation: change at which the rounds end
_UNSETTLED = 1.0  # of one that the last round still changes: intervals then do not hold
_ASTRAY = 1.5  # times what a regression leaves: an estimate that has not settled is none
_HELD = (
    "all torques are held from their sample until the next, and were taken so before all was fitted: the "
    'model that is written says derivative = "hat" under [processing]'
)
_WORSE, _LOST = 1.2, 10.0  # times what the round before leaves, and what the start does

Progress = Callable[[float], None]


def identify_by_instruments(
    robot: Robot,
    logs: Sequence[Log],
    open_pool: OpenPool,
    progress: Progress | None = None,
    prior: Robot | None = None,
) -> Identified:
    """Identify `robot`; its own parameters are never used. Raises LogError.

    open_pool   robot -> context manager of processes that hold its FMU
    prior       to which the written model stays near; its hinges are simulated where the logs tell of none
    Where the model cannot be simulated, or does not follow the logs, the estimate has no intervals. Where
    nothing says what drives the joints, and all positions are late or early by what counts, they are moved,
    if that leaves less.
    """
    told = progress or (lambda _: None)
    if driven(robot):
        return _identified(robot, logs, open_pool, told, prior)[0]
    found, late, left = _identified(robot, logs, open_pool, lambda share: told(share / 2), prior)
    if late is None or not late.sure:
        return found
    clock = Alignment.by_clock(robot, late.time, max((log.period for log in logs), default=np.inf))
    moved, known = clock.of_all(robot, logs), replace(late, std=0.0) if clock.held else late
    taken, rest = clock.taken(robot), lambda share: told((1 + share) / 2)
    again, _, since = _identified(taken, moved, open_pool, rest, prior, (found, known))
    if left is None or since is None or since.in_motion >= left.in_motion:
        return found  # a loop's answer to the noise of its encoders looks like a delay, too
    return replace(again, notes=(*again.notes, _HELD if clock.held else _moved(late)))


def by_instruments(found: Identified) -> bool:
    """Whether its values are those of `identify_by_instruments`, whose equations are `logged`."""
    return found.estimator in (NAME, START)


def _unsettled(away: float) -> str:
    return (
        f"the estimate had not settled after {_ROUNDS} rounds: the last one still changed a value by "
        f"{away:.2g} standard deviations, so no intervals are given; longer logs or less noise help"
    )


def _moved(late: Late) -> str:
    way = "late" if late.time > 0 else "early"
    return (
        f"all positions come {1e3 * abs(late.time):.2g} ± {1e3 * CONFIDENCE * late.std:.1g} ms {way} against "
        "the torques (another clock, or a filter of either), and were moved by that before all was fitted"
    )


def _identified(
    robot: Robot,
    logs: Sequence[Log],
    open_pool: OpenPool,
    progress: Progress,
    prior: Robot | None,
    before: tuple[Identified, Late] | None = None,
) -> tuple[Identified, Late | None, Rest | None]:
    """What logs say, how late their positions are, and what is left of the torques, if that is settled.

    before   the first two until positions were moved by that, which is not asked again
    """
    start = begun(robot, logs, prior)
    best = start.starts[0]
    known = [] if before is None else [before[0]]
    nearby = (known or start.starts)[0].robot
    followed, again = repeats(nearby, logs)
    notes = tuple(r.note for r in again[:1] if r.note)
    again = _quiet(nearby, again)
    try:
        with open_pool(followed) as workers:
            best = nearest([*start.starts, *known], again, workers)
            last = _rounds(start, again, best, workers, progress, prior)
        solution = with_covariance(last.logs, last.rows, last.equations, last.solution)
    except (SimulationError, NotFollowedError) as error:
        best = start.starts[1] if prior is not None and best is start.starts[0] else best
        return _of_start(robot, best, _why(error), notes), None, None
    late = None
    away = last.largest(last.gap) if driven(robot) else 0.0
    if before is not None:
        solution = replace(solution, covariance=solution.covariance + before[1].variance)
    elif not driven(robot):
        late = positions_late(last.logs, last.frames, last.rows, last.equations, solution)
        if late is not None and not late.sure:
            solution = replace(solution, covariance=solution.covariance + late.variance)
    reduced = start.plain.reduced
    found = identified(robot, reduced, solution)
    if prior is not None:
        found = near(found, prior)
        notes = (*notes, *found.notes, *disagreements(found))
    else:
        notes = (*notes, *impossible(found))
    if away > _UNSETTLED and found.relative_error["all"] > _ASTRAY * best.relative_error["all"]:
        return _of_start(robot, best, _astray(found, best), notes), None, None
    notes = (*notes, _unsettled(away)) if away > _UNSETTLED else notes
    left = _left_of(last, solution.p, len(robot.joints))
    notes = (*notes, *slow_rest(left.left, left.periods))
    fast = ringing(found.robot, [d.part.motion for d in start.data], max(log.period for log in logs))
    if fast:
        told = without_intervals_of(solution, reduced.columns, fast)
        found = replace(found, solution=told, base=base_parameters(reduced, told))
        why = "their hinges vibrate faster than the samples can follow"
        notes = (*notes, f"no interval for {', '.join(fast)}: {why}")
    found = without_intervals(found) if away > _UNSETTLED else found
    return replace(found, estimator=NAME, notes=notes), late, left


def _left_of(last: Round, p: np.ndarray, joints: int) -> Rest:
    pairs = zip(last.logs.data, last.logs.again, strict=True)
    return Rest(
        [(r.residual(p) * r.share)[:, :joints] for r in last.rows],
        [(r.y * r.share)[:, :joints] for r in last.rows],
        [again.log.period * data.part.thinning for data, again in pairs],
    )


def _of_start(robot: Robot, best: Identified, why: str, notes: Sequence[str]) -> Identified:
    """The estimate from which simulations lead nowhere, without intervals, and why it is that."""
    name = best.estimator if robot.settings.processing.filters else START
    note = f"{why}; the estimate is that of {name} and has no intervals"
    said = (*notes, note, *best.notes, *hardly_told(best.base))
    return replace(without_intervals(best), estimator=name, notes=said)


def _astray(found: Identified, best: Identified) -> str:
    """Why an estimate that had not settled is none."""
    left, before = (f"{of.relative_error['all']:.3g} %" for of in (found, best))
    return (
        f"instruments of simulations lead away from these logs ({left} of the torques are left, a regression "
        f"leaves {before}), as where the [controller] of the robot file does not drive this machine"
    )


def robot_by_instruments(
    robot: Robot, logs: Sequence[Log], again: Sequence[Repeat], workers: Workers
) -> tuple[Robot, float]:
    """The robot that `identify_by_instruments` finds, without intervals, which take most of its time.

    And the time [s] by which positions are late, where nothing drives the joints and that is sure, else 0.

    again   how each log is made again
    Where the rounds fail in a known loop it is the start that they began from, whose instruments hold little
    noise.
    Raises LogError, SimulationError, NotFollowedError.
    """
    start = begun(robot, logs)
    again = _quiet(start.starts[0].robot, again)
    best = nearest(start.starts, again, workers)
    try:
        last = _rounds(start, again, best, workers)
    except (SimulationError, NotFollowedError):
        if robot.settings.processing.filters or not driven(robot):
            raise
        return best.robot, 0.0
    late = None
    if not driven(robot):
        late = positions_late(last.logs, last.frames, last.rows, last.equations, last.solution)
    found = identified(robot, start.plain.reduced, last.solution).robot
    return found, late.time if late is not None and late.sure else 0.0


def _quiet(robot: Robot, again: Sequence[Repeat]) -> Sequence[Repeat]:
    """What makes logs again, without noise where measured motions are references; `robot` is fitted."""
    return again if driven(robot) else tuple(smoothed(robot, r) for r in again)


def _why(error: SimulationError | NotFollowedError) -> str:
    if isinstance(error, NotFollowedError):
        return str(error)
    return f"the model found cannot be simulated ({error})"


def _rounds(
    start: Begun,
    again: Sequence[Repeat],
    best: Identified,
    workers: Workers,
    progress: Progress | None = None,
    prior: Robot | None = None,
) -> Round:
    """The round from the best start with the smallest gap. Raises SimulationError, NotFollowedError."""
    robot, data, wanted = start.robot, start.data, best.robot
    steps: FixedPoint | None = None
    last: Round | None = None
    settled: Round | None = None
    before: Robot | None = None
    followers = Followers(start, again, workers, prior)
    for number in range(_ROUNDS):
        found = last.solution if last else best.solution
        try:
            made = followers.towards(wanted, found, before)
        except (SimulationError, NotFollowedError):
            if last is None or driven(robot):
                raise
            break  # nothing of a simulation but its instruments is in the estimate: the last ones do
        if steps is not None:
            steps.went(made.share)
        wanted = made.wanted
        before = wanted if driven(robot) else None  # else a failure may be the doing of what stands in
        if reads_load(robot):
            robot = robot.with_parameters(wanted.linear_parameters)
            data = gathered(partial(in_memory, robot), [d.part for d in data])
        near = number >= _NEAR or (last is not None and last.largest(last.gap) <= _SETTLED)
        logs = Repeated(robot, data, again, start.plain.reduced)
        last = next_round(logs, made, last, workers if near else None)
        if not driven(robot) and settled is not None and last.over(settled.solution.p) > _WORSE:
            break  # a worse model has worse instruments
        if last.columns is not None and steps is None:
            steps = FixedPoint(np.eye(len(last.gap)), last.std)
        if (
            settled is None
            or settled.columns is None
            or last.largest(last.gap) <= settled.largest(settled.gap)
        ):
            settled = last
        step = last.gap if steps is None else steps.step(last.gap)
        wanted = wanted.with_parameters(_changed(wanted.linear_parameters, step))
        if progress:
            progress((number + 1) / _ROUNDS)
        measured = bool(np.isfinite(last.std).any())  # else nothing tells whether rounds get nearer
        if not measured or (last.columns is not None and last.largest(step) <= _SETTLED):
            break
    assert settled is not None
    if not driven(robot) and (times := settled.over(best.solution.p)) > _LOST:
        raise NotFollowedError(f"its instruments tell too little: with it {times:.2g} times as much is left")
    return settled


def _changed(values: Mapping[str, float], step: np.ndarray) -> dict[str, float]:
    return {name: v + s for (name, v), s in zip(values.items(), step.tolist(), strict=True)}
