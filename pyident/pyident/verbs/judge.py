"""Models against logs: where they fail, which effect is missing, whether an added one is borne out."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from flexmodels.coordinate import joint_name
from flexmodels.named_values import with_settings
from flexmodels.robot import Robot, RobotError
from pyident.checks.defect import Defect
from pyident.comparison.compare import Comparison
from pyident.comparison.compare import compare as compared
from pyident.conditioning.alignment import NOTHING, Alignment
from pyident.diagnosis.diagnose import diagnose as diagnosed
from pyident.diagnosis.diagnose import servo_delay_in
from pyident.diagnosis.drives.unseen import stated as springs_stated
from pyident.diagnosis.notes import apart as kept_apart
from pyident.diagnosis.searched import alignment_in, part_of
from pyident.estimation.lock_unlogged import unlocked
from pyident.extension.add_effect import add_effect as extended
from pyident.extension.divide import divided, instants
from pyident.extension.extended_robot import require_new
from pyident.extension.split import split
from pyident.regression.machine.linear_algebra import one_thread
from pyident.report.moving_arm import MovingArm, moving
from pyident.simulation.denoised import within
from pyident.simulation.fmu_runs import FmuRuns
from pyident.simulation.processes.this_machine import processes_kept
from pyident.verbs.fit import identify, on_springs, with_found_drive
from pyident.verbs.inputs import Columns, Given, Logs, Model, as_rigid, given, robot_of
from pyident.verbs.judged import Added, Compared, Diagnosed

Progress = Callable[[float], None]
_DIAGNOSIS, _EXTENSION = diagnosed.__module__, extended.__module__  # what their processes are to import


@one_thread()
def compare(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    parameters: Mapping[str, float] | None = None,
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Compared:
    """Where an identified model fails on logs, beside the floor that the method leaves on replicas of it.

    parameters   values that replace the model's own, by name, in SI units
    A model that cannot be simulated is judged by its equations alone. Where a rigid robot's loop is unknown
    and something stands out, what keeps positions and torques apart is put right first, as `diagnose` does.
    The others as in `identify`. Raises RobotError, LogError, BuildError.
    """
    told = progress or _silent
    robot = robot_of(model, parameters, allow_effects)
    read = _on_stated_springs(robot, given(robot, logs, mapping, force=force))
    outcome = compared(read.robot, read.logs, FmuRuns, lambda share: told(0.5 * share))
    apart = alignment_in(read.robot, read.logs, FmuRuns) if outcome.tracks and outcome.where else NOTHING
    if apart.needed:
        read = _put_right(read, apart)
        outcome = compared(read.robot, read.logs, FmuRuns, lambda share: told(0.5 + 0.5 * share))
    told(1.0)
    return Compared(outcome, read.notes, tuple(_arms(read, outcome)))


def _put_right(read: Given, apart: Alignment) -> Given:
    """What was read with its positions and torques together, and a note on that."""
    note = f"{kept_apart(apart)}; that was put right before all was judged"
    logs, heldout = (tuple(apart.of_all(read.robot, of)) for of in (read.logs, read.heldout))
    robot = within(apart.taken(read.robot), apart.band)
    return replace(read, robot=robot, logs=logs, heldout=heldout, notes=(*read.notes, note))


@processes_kept(_DIAGNOSIS)
@one_thread()
def diagnose(
    model: Model,
    logs: Logs,
    *,
    heldout: Logs = (),
    mapping: Columns | None = None,
    parameters: Mapping[str, float] | None = None,
    draft: bool = False,
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Diagnosed:
    """Which effect a model lacks in its logs; its own dynamic parameters are never used.

    heldout      logs to judge on; none: the last of several, or the last third of the only one
    parameters   what is known of the servos in these logs, such as {"servo.kp": 400}
    draft        look for a formula where no law explains the residual (needs flexident[symbolic])
    The others as in `identify`. Raises RobotError, LogError, BuildError.
    """
    known = _with_drive(model, parameters, allow_effects)
    read, drive, rest = _with_loop(known, logs, mapping, heldout, force, progress or _silent)
    parts = split(read.logs, read.heldout)
    times = instants((*read.logs, *read.heldout), read.defects)
    (fitted, taken_up), (unseen, put_down) = (divided(logs, times) for logs in (parts.fitted, parts.unseen))
    found = diagnosed(read.robot, fitted, FmuRuns, unseen, rest, draft)
    said_again = _of_time(read.defects) if found.put_in_time else set()
    checked = [note for note in read.notes if note not in said_again]
    notes = (*drive, *checked, *taken_up, *put_down, *found.notes)
    return Diagnosed(replace(found, notes=notes), notes)


def _of_time(defects: Sequence[Defect]) -> set[str]:
    """What checks said of a delay of all torques: a diagnosis that put them in time says more of it."""
    return {d.sentence for d in defects if d.delays_all}


@processes_kept(_EXTENSION)
@one_thread()
def add_effect(
    model: Model,
    effect: str,
    joint: int,
    logs: Logs,
    *,
    heldout: Logs = (),
    mapping: Columns | None = None,
    parameters: Mapping[str, float] | None = None,
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Added:
    """The model with one more effect at `joint` (from 1), fitted, and judged on data that were held out.

    effect                its name in the catalogue or in the robot's own files, or `geometry`
    heldout, parameters   as in `diagnose`
    The others as in `identify`. What keeps positions and torques apart is put right first, as in `diagnose`.
    Raises RobotError where the law cannot act, LogError, SimulationError, BuildError.
    """
    known = _with_drive(model, parameters, allow_effects)
    require_new(known, joint, effect)  # before logs are read
    read, drive, rest = _with_loop(known, logs, mapping, heldout, force, progress or _silent)
    apart = alignment_in(read.robot, read.logs, FmuRuns)
    read, band = _put_right(read, apart) if apart.needed else read, read.robot.settings.processing.band
    found = extended(read.robot, joint, effect, read.logs, read.heldout, FmuRuns, rest)
    found = replace(found, robot=replace(_judged_up_to(found.robot, band), controller=known.controller))
    if not (read.hinges and found.accepted):
        return Added(found, (*drive, *read.notes))
    whole = unlocked(found.robot, read.hinges)
    again = identify(whole, logs, mapping=mapping, heldout=heldout, force=force).robot
    return Added(found, (*drive, *read.notes), replace(again, name=found.robot.name))


def _judged_up_to(robot: Robot, band: float | None) -> Robot:
    """The robot judged up to a frequency [Hz] as its file says, whatever these logs were judged up to."""
    return robot.with_settings(processing=replace(robot.settings.processing, band=band))


def _with_drive(model: Model, parameters: Mapping[str, float] | None, allow_effects: bool) -> Robot:
    """The model with what is known of its drives. Raises RobotError for what is fitted anyway."""
    robot = robot_of(model, allow_effects=allow_effects)
    fitted = sorted(set(parameters or {}) & set(robot.parameters))
    if fitted:
        raise RobotError(
            f"{fitted[0]} is fitted to the logs, so no value can be set for it; servo.kp and the like can"
        )
    return with_settings(robot, parameters) if parameters else robot


def _arms(read: Given, outcome: Comparison) -> Iterator[MovingArm]:
    """The arm along every log, its joints' colours by the equation that leaves most over its floor."""
    whole = [b for b in outcome.bins if b.kind == "all"]
    ratios = {k: [b.ratio for b in whole if b.joint == joint_name(k)] for k, _ in read.robot.numbered}
    over_floor = {k: max(listed) for k, listed in ratios.items() if listed}
    for log, errors in zip(read.logs, outcome.logs, strict=True):
        if not errors.missed:  # nothing was simulated
            continue
        yield moving(read.robot, log.source, log.frame, errors.time, errors.missed, over_floor)


def _with_loop(
    robot: Robot,
    logs: Logs,
    mapping: Columns | None,
    heldout: Logs,
    force: bool,
    progress: Progress,
) -> tuple[Given, tuple[str, ...], Progress]:
    """What was read, with what is unknown of servos found in the logs; notes on that, and the progress that
    is left.

    A fit to positions has a delay that what is missing bends: it is asked for again beside laws that explain.
    """
    robot, notes = with_found_drive(robot, logs, mapping, force, part_of(progress, 0.0, 0.1))
    read = given(robot, logs, mapping, heldout, force)
    if not notes:
        return on_springs(robot, read, split(read.logs, read.heldout).fitted), (), progress
    if robot.servo is None or "delay" not in robot.servo.unknown:
        return read, notes, part_of(progress, 0.1, 0.9)
    parts = split(read.logs, read.heldout)
    late = servo_delay_in(read.robot, parts.fitted, FmuRuns, parts.unseen, part_of(progress, 0.1, 0.3))
    if late:
        delay = max(robot.servo.delay + late, 0.0)
        robot = with_settings(robot, {"servo.delay": delay})
        read = given(robot, logs, mapping, heldout, force)
        notes = (*notes, f"servo.delay {delay:.3g} leaves less of the equations, and is taken here")
    return read, notes, part_of(progress, 0.4, 0.6)


def _on_stated_springs(robot: Robot, read: Given) -> Given:
    """What was read, its torques as rigid drives need them by the springs of the model."""
    drives = springs_stated(robot, read.robot, read.logs[0])
    if drives is None:
        return read
    said = ", ".join(map(str, drives.springs))
    note = (
        f"no link-side encoder at joint {said}: torques are taken as rigid drives need them, by the model's "
        "hinges, bodies and motors"
    )
    return as_rigid(read, drives.rigid, drives.hinges(read.logs[0]), [note])


def _silent(_: float) -> None:
    """Progress that nobody asked for."""
