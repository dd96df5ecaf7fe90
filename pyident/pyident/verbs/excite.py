"""The next experiment: a motion that tells the most, checked before a machine runs it."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from itertools import chain
from pathlib import Path

from flexmodels.inputs import Experiment
from flexmodels.robot import Robot, RobotError
from pyident.excitation.design import (
    Design,
    best_conditioned,
    confined,
    designed,
    measure,
    most_informative,
    nearer,
)
from pyident.excitation.drawing import Drawing, starts
from pyident.excitation.limits import amid
from pyident.excitation.prediction import predicted
from pyident.excitation.rehearsals.rehearsal import (
    SPREAD,
    Rehearsal,
    of_others,
    others_like,
    reference_of_plan,
    rehearsal,
    violations,
    worst,
)
from pyident.excitation.rehearsals.violations import of_ends
from pyident.excitation.search import Budget
from pyident.excitation.separation.contest import Contest
from pyident.excitation.separation.rivals import Rivals, Suspect, having, suspect, taken_out
from pyident.excitation.separation.search import Separation
from pyident.excitation.tables import write_table
from pyident.excitation.task import Task, require_long_enough, require_over_the_floor, slow, task_of
from pyident.simulation.fmu_runs import runs_in_threads
from pyident.simulation.references import load_experiment
from pyident.verbs.inputs import Model, robot_of
from pyident.verbs.planned import Checked, Planned, Promise

Progress = Callable[[float], None]
Pair = tuple[Suspect | None, Suspect | None]
CRITERIA = {"information": most_informative, "condition": best_conditioned}
_OTHERS = 24
_PROMISED = range(101, 117)  # seeds of the noise under which a promise is made: none of the search's
_DESIGNING, _RUNNING = 0.9, 0.6  # of the time; the rest is what a log will tell
_SEEDS = 2**32 - 1  # as NumPy's older generators take them


def excite(
    model: Model,
    *,
    separate: Sequence[str] = (),
    reveal: str | None = None,
    criterion: str = "information",
    duration: float = 10.0,
    rate: float | None = None,
    limits: Mapping[str, float] | None = None,
    home: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    radius: float | None = None,
    floor: float | None = 0.0,
    spread: float = SPREAD,
    evaluations: int = 1500,
    seconds: float = 120.0,
    seed: int = 0,
    allow_effects: bool = False,
    progress: Progress | None = None,
) -> Planned:
    """A motion that determines the parameters best, or tells two effects apart, or shows one.

    model       as in `identify`; its own parameters predict what the motion takes. A law of it that is asked
                about is taken out, and its values there are supposed of it where none are given
    separate    two of `EFFECT@JOINT` that should be told apart, `=SIZE` or `=PARAMETER=VALUE,...` after it
    reveal      one of them that should be seen
    criterion   of an identification: `information` in the sensors' noise, or `condition` of the regressor
    duration    [s];  rate  [Hz] of the plan, none: the controller's
    limits      `joint{k}.lower`, `.upper`, `.speed`, `.acceleration`, `.torque` beside the file's, SI units
    home        joint -> where it sets out [rad or m]; others do at 0, or amid their range where 0 is outside
    noise       channel -> standard deviation of its sensor, beside an encoder noise of 1e-5
    radius      [m] of the links as capsules;  floor  its height [m] over the base, None: there is none
    spread      share by which the model's parameters may be off; robots so far off keep the limits, too
    evaluations, seconds   what the search may cost; an interrupt ends it with the best so far
    seed        of the search: the same finds the same
    The others as in `identify`. Raises RobotError, SimulationError, BuildError.
    """
    robot = robot_of(model, allow_effects=allow_effects)
    asked = tuple(suspect(text) for text in separate)
    if asked and (len(asked) != 2 or reveal):
        raise RobotError("separate takes two effects, and reveal one; ask for one of them")
    if len(set(asked)) < len(asked):
        raise RobotError(f"{separate[0]} cannot be told from itself; name two effects")
    pair: Pair | None = (asked[0], asked[1]) if asked else None
    if reveal:
        pair = (suspect(reveal), None)
    robot, pair, out = _without_suspects(robot, pair)
    if criterion not in CRITERIA:
        raise RobotError(f"there is no criterion {criterion!r}; take one of {', '.join(CRITERIA)}")
    task = task_of(robot, duration, rate, limits, noise, radius, floor, spread, home)
    if not seconds > 0 or not 0 <= seed < _SEEDS or evaluations < 1:
        raise RobotError(f"a search needs seconds, an evaluation and a seed from 0 to {_SEEDS - 1}")
    budget, drawing = Budget(evaluations, seconds, seed), Drawing(task)
    require_over_the_floor(task)
    require_long_enough(task)
    begins = (*amid(robot, task.limits, home or {}), *slow(task))
    with rehearsal(robot) as own:
        told = _first(_DESIGNING, progress)
        if pair is not None:
            found, promise = _apart(task, drawing, own, pair, budget, told)
        else:
            found, promise = designed(task, drawing, CRITERIA[criterion], own, budget, told), None
        prediction = predicted(own, found.plan, task.noise, runs_in_threads)
    if progress:
        progress(1.0)
    notes = (
        *out,
        *_notes(task),
        *begins,
        *nearer(task, found),
        *confined(task, found.plan),
        *prediction.notes,
    )
    return Planned(robot, found, notes, prediction, promise)


def check_plan(
    plan: Experiment | str | Path,
    model: Model,
    *,
    limits: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    radius: float | None = None,
    floor: float | None = 0.0,
    spread: float = SPREAD,
    others: int = _OTHERS,
    allow_effects: bool = False,
    progress: Progress | None = None,
) -> Checked:
    """Whether a robot may run a plan: limits, rest at its ends, torques in simulation, its links, the floor.

    plan     an Experiment, or what `simulate` takes as one
    others   robots that rehearse it too, with parameters off by 0.4 to 1 of `spread`, 24 side by side
    The others as in `excite`. Raises RobotError, ExperimentError, SimulationError, BuildError.
    """
    robot = robot_of(model, allow_effects=allow_effects)
    read = plan if isinstance(plan, Experiment) else load_experiment(robot, str(plan))
    rate = 1 / float(read.time[1] - read.time[0])
    task = task_of(
        robot, float(read.time[-1]), rate, limits, noise, radius, floor, spread, begin=read.reference[0]
    )
    with rehearsal(robot) as own:
        like = others_like(robot, others, seed=2, spread=spread)
        found = of_ends(robot, task.limits, reference_of_plan(read))
        found += violations(own, task.limits, task.geometry, read)
        told = _first(_RUNNING, progress) or (lambda _: None)
        runs = of_others(own, task.limits, task.geometry, read, like, told)
        prediction = predicted(own, read, task.noise, runs_in_threads)
    if progress:
        progress(1.0)
    broken = sum(bool(run) for run in runs)
    listed = worst([*found, *chain.from_iterable(runs)])
    notes = (*_notes(task), *prediction.notes)
    return Checked(robot, tuple(listed), notes, prediction, others, broken)


def export_plan(
    plan: Experiment | str | Path,
    model: Model,
    path: str | Path,
    *,
    rate: float | None = None,
    degrees: bool = False,
    allow_effects: bool = False,
) -> Path:
    """Write a plan's references as a table (.csv) or a ROS JointTrajectory (.json, .yaml); its path.

    path      ends in .csv, .json or .yaml
    rate      points a second, none: the plan's own;  degrees  and mm in a table, instead of SI units
    The others as in `check_plan`. Raises RobotError, ExperimentError.
    """
    robot = robot_of(model, allow_effects=allow_effects)
    read = plan if isinstance(plan, Experiment) else load_experiment(robot, str(plan))
    own = 1 / float(read.time[1] - read.time[0])
    return write_table(robot, read, path, own if rate is None else rate, degrees)


def _without_suspects(robot: Robot, pair: Pair | None) -> tuple[Robot, Pair | None, list[str]]:
    """The robot without the laws that are asked about, these with what it said of them, and notes."""
    known: list[Suspect | None] = []
    notes: list[str] = []
    for who in pair or ():
        plain, asked = (robot, None) if who is None else taken_out(robot, who)
        known.append(asked)
        if asked is not None and plain is not robot:
            notes.append(
                f"{asked.name} is in the model: it was taken out to be asked about, and its values there are "
                "supposed of it where none are given; the motion keeps its limits with it, too"
            )
        robot = plain
    return robot, (known[0], known[1]) if pair else None, notes


def _apart(
    task: Task,
    drawing: Drawing,
    own: Rehearsal,
    pair: Pair,
    budget: Budget,
    progress: Progress | None,
) -> tuple[Design, Promise]:
    """The motion that brings two rivals apart; None of a pair is the robot as it is."""
    level = measure(task, drawing, own)
    drawn = (drawing.reference(x, 1 / task.rate) for x in starts(drawing.family, 20))
    log = own.log(drawing.plan(next(reference for reference in drawn if reference is not None)))
    first, second = (task.robot if who is None else having(task.robot, who, log) for who in pair)
    rivals = Rivals(task.robot, pair, (first, second))
    with ExitStack() as stack:
        theirs = [stack.enter_context(rehearsal(robot)) for robot in rivals.robots]
        contest = Contest(rivals, theirs, task.noise)
        score = rivals.score(rivals.grids(log))
        found = Separation(task, contest, score, level).designed(own, budget, progress)
        sigmas = contest.sigmas(found.plan, _PROMISED)
    names = ["nothing" if who is None else who.name for who in pair]
    return found, Promise((names[0], names[1]), sigmas, rivals.robots)


def _first(part: float, progress: Progress | None) -> Progress | None:
    """Of something that takes the first part of the time."""
    return progress and (lambda share: progress(part * share))


def _notes(task: Task) -> tuple[str, ...]:
    return (*task.limits.notes, *task.geometry.notes, *_unknown_noise(task))


def _unknown_noise(task: Task) -> tuple[str, ...]:
    """A note where nothing tells the noise of torques that are measured."""
    quiet = [name for name in task.robot.torques if name not in task.noise]
    if task.robot.controller is not None or not quiet:
        return ()
    return (
        f"nothing tells the noise of {', '.join(quiet)}: what is promised counts none; "
        f"--noise {quiet[0]}=0.1 gives one",
    )
