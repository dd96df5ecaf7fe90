"""A plan run in simulation before a machine runs it: by the robot, and by robots a little different."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from flexmodels.coordinate import feedforward_of, reference_of, torque_of
from flexmodels.experiment import Experiment
from flexmodels.link import LINK_PARAMETERS, Link
from flexmodels.robot import Robot, RobotError
from pyident.excitation.capsules import Geometry
from pyident.excitation.followed import followed
from pyident.excitation.fourier import Reference
from pyident.excitation.limits import Limits
from pyident.excitation.rehearsals.violations import Violation, of_reference, of_run
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import fmu_here

_FEWEST = 3  # samples of a plan: accelerations are their second differences

SPREAD = 0.25  # by which the parameters of the others are off at most
_LEAST = 0.4  # of the spread, by which they are off at least
_AT_ONCE = 24  # of them that are simulated side by side


@dataclass(frozen=True)
class Rehearsal:
    """Runs of one robot's FMU; without a drive in its file, references are taken as followed exactly."""

    robot: Robot
    fmu: Any

    def log(self, plan: Experiment) -> Log:
        """Noise-free. Raises SimulationError."""
        frame = self._follow(plan) if self.fmu is None else self.fmu.simulate(plan)
        return Log(frame, self._source)

    def noisy(self, plan: Experiment, noise: Mapping[str, float], seeds: Sequence[int]) -> list[Log]:
        """A log per seed with white noise of the sensors (channel -> standard deviation).

        That of an encoder passes through the loop. Raises SimulationError.
        """
        if self.fmu is None:
            clean = self.log(plan)
            return [clean.noisier(noise, np.random.default_rng(seed)) for seed in seeds]
        encoders = {name: noise[name] for name in self.robot.coordinates if name in noise}
        torques = {name: sigma for name, sigma in noise.items() if name not in encoders}
        frames = self.fmu.simulate_batch(plan, [self.robot.parameters], encoders, list(seeds))
        return [
            Log(frame, self._source).noisier(torques, np.random.default_rng(seed))
            for frame, seed in zip(frames, seeds, strict=True)
        ]

    @property
    def _source(self) -> str:
        return f"simulation of {self.robot.name}"

    def others(self, plan: Experiment, robots: Sequence[Robot]) -> list[pd.DataFrame]:
        """Runs of robots with other parameters. Raises SimulationError."""
        if self.fmu is None:
            return [Rehearsal(robot, None)._follow(plan) for robot in robots]
        return self.fmu.simulate_batch(plan, [robot.parameters for robot in robots])

    def _follow(self, plan: Experiment) -> pd.DataFrame:
        reference = reference_of_plan(plan)
        motion = followed(self.robot, reference.time, reference.q, reference.dq, reference.ddq)
        assert motion.tau is not None
        frame = pd.DataFrame(motion.q, columns=list(self.robot.coordinates))
        frame.insert(0, "time", plan.time)
        for k, _ in self.robot.numbered:
            frame[reference_of(k)] = plan.reference[:, k - 1]
            frame[torque_of(k)] = motion.tau[:, k - 1]
        return frame


@contextmanager
def rehearsal(robot: Robot) -> Iterator[Rehearsal]:
    """Use as a context manager. Raises BuildError."""
    if robot.controller is None and robot.servo is None:
        yield Rehearsal(robot, None)
        return
    with fmu_here(robot) as fmu:
        yield Rehearsal(robot, fmu)


def reference_of_plan(plan: Experiment) -> Reference:
    """The commanded motion with its derivatives. Raises RobotError for a plan of too few samples."""
    if len(plan.time) < _FEWEST:
        raise RobotError(f"a plan of {len(plan.time)} samples is no motion; give {_FEWEST} at least")
    dq = np.gradient(plan.reference, plan.time, axis=0)
    ddq = np.diff(plan.reference, 2, axis=0) / (plan.time[1] - plan.time[0]) ** 2
    return Reference(plan.time, plan.reference, dq, np.concatenate([ddq[:1], ddq, ddq[-1:]]))


def violations(rehearsal: Rehearsal, limits: Limits, geometry: Geometry, plan: Experiment) -> list[Violation]:
    """Of the reference and of the robot's run."""
    robot = rehearsal.robot
    return [
        *of_reference(robot, limits, geometry, reference_of_plan(plan)),
        *of_run(robot, limits, geometry, rehearsal.log(plan).frame),
    ]


def of_others(
    rehearsal: Rehearsal,
    limits: Limits,
    geometry: Geometry,
    plan: Experiment,
    others: Sequence[Robot],
    progress: Callable[[float], None] = lambda _: None,
) -> list[list[Violation]]:
    """Of each of the runs of robots with other parameters."""
    found = []
    for first in range(0, len(others), _AT_ONCE):
        for frame in rehearsal.others(plan, others[first : first + _AT_ONCE]):
            named = "a robot with other parameters"
            found.append(of_run(rehearsal.robot, limits, geometry, frame, named))
        progress(len(found) / len(others))
    return found


def worst(found: Iterable[Violation]) -> list[Violation]:
    """The worst of each kind, place and run."""
    out: dict[tuple[str, str, str, bool | None], Violation] = {}
    for v in found:
        key = v.what, v.where, v.of, v.time == 0 if v.what == "rest" else None
        if key not in out or _beyond(v) > _beyond(out[key]):
            out[key] = v
    return list(out.values())


def _beyond(v: Violation) -> float:
    return -v.value if v.what == "distance" else abs(v.value)


def plan_frame(plan: Experiment) -> pd.DataFrame:
    """The plan as a file holds it: time, references and feed-forward torques."""
    frame = {"time": plan.time}
    for k in range(1, plan.reference.shape[1] + 1):
        frame[reference_of(k)] = plan.reference[:, k - 1]
    for k in range(1, plan.reference.shape[1] + 1):
        frame[feedforward_of(k)] = plan.feedforward[:, k - 1]
    return pd.DataFrame(frame)


def others_like(
    robot: Robot, count: int, seed: int = 0, spread: float = SPREAD, least: float = _LEAST
) -> list[Robot]:
    """Robots whose masses, centres of mass, inertias and laws are off by up to a share, bodies physical.

    spread   the largest share;  least  of it, that everything is off by at least
    """
    rng = np.random.default_rng(seed)

    def off() -> float:
        return 1 + float(rng.choice([-1, 1]) * rng.uniform(least * spread, spread))

    out = []
    for _ in range(count):
        values = {name: v * off() for name, v in robot.parameters.items() if name.startswith("joint")}
        for k, link in enumerate(robot.links, start=1):
            changed = _scaled(link, off(), off(), off())
            values |= {f"link{k}.{name}": changed.values[name] for name in LINK_PARAMETERS}
        out.append(robot.with_parameters(values))
    return out


def _scaled(link: Link, mass: float, centre: float, spread: float) -> Link:
    """The body with factors of its mass, of its centre's place and of its inertia about the centre."""
    if link.m <= 0:
        return replace(link, J=tuple(spread * v for v in link.J))
    com, J_com = link.about_centre()
    return Link.of_centre(mass * link.m, centre * com, spread * J_com)
