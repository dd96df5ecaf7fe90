"""Motions that a robot can run: shapes under limits, scored by what they tell, and rehearsed at the end."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmodels import multisine
from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot, RobotError
from pyident.excitation.capsules import Geometry
from pyident.excitation.criterion import Along, Yardstick, along, independent, information, yardstick
from pyident.excitation.followed import followed, torques
from pyident.excitation.fourier import Family, Reference
from pyident.excitation.jury import Jury
from pyident.excitation.limits import Limits
from pyident.excitation.rehearsal import SPREAD, Rehearsal
from pyident.excitation.search import Best, Budget, best_of
from pyident.excitation.violations import of_reference

_SHARE, _TORQUE_SHARE = 0.95, 0.8  # of the limits, that a reference may use: the rest is for the loop
_WAVE_SHARE = 0.4  # of a torque limit, that a multisine may take at most
_SHRINK = 0.92
_SMALLEST = 0.05  # of the way from home: below, nothing is left of a motion
_COARSE = 50.0  # Hz at which candidates are judged
WAVES = (0.0, 0.5, 1.0)  # shares of the multisine that are tried: it shows inertias and hides friction
_SEARCH = 0.8  # of the progress; the rest is the rehearsals'

Score = Callable[[Along], float]
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Task:
    """A robot with what limits it.

    noise    channel -> standard deviation of its sensor
    spread   share by which its parameters may be off
    """

    robot: Robot
    limits: Limits
    geometry: Geometry
    noise: Mapping[str, float]
    duration: float
    rate: float
    spread: float = SPREAD
    harmonics: int = 5
    repeats: int = 1

    @property
    def family(self) -> Family:
        return Family(self.limits.within(_SHARE, 1.0), self.duration, self.harmonics, self.repeats)

    @property
    def wave(self) -> tuple[np.ndarray, np.ndarray]:
        """(N, joints) torques of the robot's own multisine, as large as the limits allow, and their peaks."""
        time = np.arange(round(self.duration * self.rate) + 1) / self.rate
        plan, joints = self.robot.settings.identification, len(self.robot.joints)
        if plan is None or self.robot.controller is None:
            return np.zeros((len(time), joints)), np.zeros(joints)
        tones = plan.multisine
        f = np.linspace(tones.lowest, min(tones.highest, 0.4 * self.rate), tones.lines)
        rng = np.random.default_rng(0)
        phases = [multisine.flattened(rng.uniform(0, 2 * np.pi, tones.lines), f) for _ in range(joints)]
        waves = np.column_stack([multisine.wave(time, f, p) for p in phases]) * np.array(tones.rms)
        fade = np.clip(np.minimum(time, time[-1] - time) / 0.25, 0, 1)[:, None]  # at rest at both ends
        waves = waves * fade
        peak = np.abs(waves).max(axis=0)
        allowed = np.minimum(1.0, _WAVE_SHARE * self.limits.torque / np.maximum(peak, 1e-12))
        return waves * allowed, peak * allowed


@dataclass(frozen=True)
class Design:
    """A plan that kept every limit in its rehearsals.

    best        the search that led to it;  scale: of the way from home that the rehearsals left
    wave        share of the robot's own multisine that is in it
    binding     what would not let it be larger, empty where nothing was in its way
    rehearsed   how many other robots ran it, with parameters off by spread
    """

    plan: Experiment
    best: Best
    scale: float
    wave: float
    binding: str
    rehearsed: int
    spread: float


class Drawing:
    """Turns numbers into references that keep the limits, torques and distances included."""

    def __init__(self, task: Task):
        self.task, self.family = task, task.family
        self.waves, peak = task.wave
        self.torque = _TORQUE_SHARE * (task.limits.torque - peak)

    def reference(self, x: np.ndarray, step: float | None = None) -> Reference | None:
        """As large as it may be; None where not even a small one is allowed."""
        coarse = 1 / min(_COARSE, self.task.rate)
        scale = 1.0
        while scale > _SMALLEST:
            reference = self.family.reference(x, coarse, scale)
            over = self._over(reference)
            if over <= 1:
                return reference if step is None else self.family.reference(x, step, scale)
            scale *= max(0.5, min(_SHRINK, 1 / over))
        return None

    def _over(self, reference: Reference) -> float:
        """Largest torque over what is allowed; 2 where links come too near."""
        robot = self.task.robot
        motion = followed(robot, reference.time, reference.q, reference.dq, reference.ddq)
        tau = motion.tau if motion.tau is not None else torques(robot, motion)
        worst = float((np.abs(tau).max(axis=0) / self.torque).max())
        if worst <= 1 and of_reference(robot, self.task.limits, self.task.geometry, reference):
            return 1 / _SHRINK
        return worst

    def plan(self, reference: Reference, wave: float = 1.0) -> Experiment:
        """With the multisine."""
        return Experiment(reference.time, reference.q, wave * self.waves[: len(reference.time)])


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


def designed(
    task: Task,
    drawing: Drawing,
    score: Score,
    level: Yardstick,
    rehearsal: Rehearsal,
    budget: Budget,
    progress: Progress | None = None,
    rivals: Sequence[Rehearsal] = (),
    worth: Callable[[Experiment], float] | None = None,
) -> Design:
    """The motion with the highest score, made smaller until it and its rehearsals keep the limits.

    rivals   whose limits it must keep too
    worth    of a plan, by simulation, which chooses the share of the robot's own multisine; None: all of it
    Raises RobotError where none does.
    """

    def judged(x: np.ndarray) -> float:
        reference = drawing.reference(x)
        return -np.inf if reference is None else score(along(task.robot, level, reference))

    told = progress or (lambda _: None)
    best = best_of(judged, starts(drawing.family, 12), budget, lambda share: told(_SEARCH * share))
    drawn = drawing.reference(best.x, 1 / task.rate)
    if drawn is None:
        raise RobotError(f"robot {task.robot.name}: no motion was found that keeps the limits")
    jury = Jury(task.robot, task.limits, task.geometry, (rehearsal, *rivals), task.spread)
    wave = 1.0 if worth is None else max(WAVES, key=lambda share: worth(drawing.plan(drawn, share)))
    scale, home, binding = 1.0, task.limits.home, ""
    while scale > _SMALLEST:
        told(_SEARCH + (1 - _SEARCH) * np.log(scale) / np.log(_SMALLEST))
        reference = replace(
            drawn, q=home + scale * (drawn.q - home), dq=scale * drawn.dq, ddq=scale * drawn.ddq
        )
        plan = drawing.plan(reference, scale * wave)
        if not (broken := jury.broken(plan)):
            return Design(plan, best, scale, wave, binding, len(jury.others), task.spread)
        scale, binding = scale * _SHRINK, broken
    raise RobotError(
        f"robot {task.robot.name}: not even a small motion keeps a limit of {binding} with parameters "
        f"{100 * task.spread:g} % off; give a smaller spread, or the robot a loop that allows for it"
    )


def starts(family: Family, count: int) -> list[np.ndarray]:
    """Random members of the family, the same for the same count."""
    rng = np.random.default_rng(0)
    return [rng.standard_normal(family.size) for _ in range(count)]
