"""From Coulomb and viscous friction up: how far up a ladder of laws the recordings themselves ask for.

Each rung adds a law to the one before. It is fitted without one motion at a time and judged on that motion;
of the rungs within a tenth of the best the lowest is taken. What the study holds out never takes part.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.named_values import settable, with_settings
from flexmodels.robot import Robot
from pyident.refinement.closed_loop import ClosedLoopFit, ServoLog, fit_closed_loop, replay_errors
from pyident.simulation.fmu_runs import runs_here
from pyident.simulation.simulator import Simulate

Recordings = Mapping[str, ServoLog]

SATURATION = "saturation"  # of the motor's iron: a number of the servo, not a law at the joint
LAWS = ("load_dependent_friction", SATURATION, "stribeck", "quadratic_load_friction")
_NEAR = 1.1  # times the least error on motions that were not fitted: what a lower rung may have
_ROUNDS = 100  # at most: fits end where the error falls no longer, those that only serve the choice, too
_FIRST = 0.05  # [1/A] from which the saturation is sought
_POSE = ("link1.ms[x]",)  # the zero of the encoder is not quite straight down


@dataclass(frozen=True)
class Climbed:
    """robot: the chosen structure;  told: the rungs' errors and which was taken, a sentence each."""

    robot: Robot
    told: tuple[str, ...]

    @property
    def laws(self) -> str:
        """Those beyond Coulomb and viscous friction."""
        return ", ".join(law for law in LAWS if _has(self.robot, law)) or "no further law"


class Fits:
    """Fits and replays of one servo with any of the laws; a structure is compiled once."""

    def __init__(self, stack: ExitStack):
        self._stack = stack
        self._compiled: dict[frozenset[str], Simulate] = {}

    def fit(self, robot: Robot, recordings: Sequence[ServoLog]) -> ClosedLoopFit:
        """Drive, friction, armature and pose from recordings."""
        assert robot.servo is not None
        joint = (name for name in robot.parameters if name.startswith("joint1."))
        return fit_closed_loop(
            robot, recordings, [*robot.servo.free, *joint, *_POSE], self._runs(robot), _ROUNDS
        )

    def error(self, robot: Robot, recordings: Sequence[ServoLog]) -> float:
        """Mean absolute position error [degrees], a mean over recordings."""
        replays = self.replays(robot, recordings)
        return float(np.degrees(np.mean([np.abs(error).mean() for _, error in replays])))

    def replays(self, robot: Robot, recordings: Sequence[ServoLog]) -> list[tuple[pd.DataFrame, np.ndarray]]:
        """Per recording its simulation, and simulated − measured positions [rad]."""
        return replay_errors(robot, recordings, self._runs(robot))

    def _runs(self, robot: Robot) -> Simulate:
        laws = frozenset(robot.joints[0].values)
        if laws not in self._compiled:
            self._compiled[laws] = self._stack.enter_context(runs_here(robot))
        simulate = self._compiled[laws]
        own = settable(robot)  # the compiled robot may have other values
        return lambda plan, sets: simulate(plan, [{**own, **values} for values in sets])


@contextmanager
def fits() -> Iterator[Fits]:
    """What is compiled lasts as long as the context."""
    with ExitStack() as stack:
        yield Fits(stack)


def climbed(start: Robot, recordings: Recordings, fits: Fits, progress: Callable[[float], None]) -> Climbed:
    """The structure that these recordings ask for, its values those of a fit without the first motion."""
    folds = _folds(recordings)
    robots, rungs, errors, told = [start] * len(folds), [], [], []
    for number in range(len(LAWS) + 1):
        progress(number / (len(LAWS) + 1))
        if number:
            robots = [_with(robot, LAWS[number - 1]) for robot in robots]
        robots, error = _judged(robots, folds, fits)
        rungs.append(robots[0])
        errors.append(error)
        name = f"with {LAWS[number - 1]}" if number else "Coulomb and viscous friction"
        told.append(f"{name}: {error:.2f}° on motions that were not fitted")
    taken = next(i for i, error in enumerate(errors) if error <= _NEAR * min(errors))
    chosen = Climbed(rungs[taken], tuple(told))
    progress(1.0)
    return replace(chosen, told=(*told, f"taken, the lowest within a tenth of the best: {chosen.laws}"))


def _folds(recordings: Recordings) -> list[tuple[list[ServoLog], list[ServoLog]]]:
    """To fit and to judge: a motion at a time is judged, at all of its gains."""
    motion = {name: name.rpartition("_kp")[0] for name in recordings}
    return [
        (
            [r for name, r in recordings.items() if motion[name] != judged],
            [r for name, r in recordings.items() if motion[name] == judged],
        )
        for judged in sorted(set(motion.values()))
    ]


def _judged(
    robots: Sequence[Robot], folds: Sequence[tuple[list[ServoLog], list[ServoLog]]], fits: Fits
) -> tuple[list[Robot], float]:
    """The robots fitted, each in its fold, and their mean absolute error on what is judged [degrees]."""
    fitted, errors = [], []
    for robot, (fit_to, judge_on) in zip(robots, folds, strict=True):
        fitted.append(fits.fit(robot, fit_to).robot)
        errors.append(fits.error(fitted[-1], judge_on))
    return fitted, float(np.mean(errors))


def _with(robot: Robot, law: str) -> Robot:
    if law != SATURATION:
        return robot.with_effect(1, law)
    robot = with_settings(robot, {f"servo.{SATURATION}": _FIRST})
    assert robot.servo is not None
    return replace(robot, servo=replace(robot.servo, unknown=(*robot.servo.unknown, SATURATION)))


def _has(robot: Robot, law: str) -> bool:
    assert robot.servo is not None
    return law in robot.servo.unknown if law == SATURATION else law in robot.joints[0].values
