"""Which motion would tell rival models apart, found by simulating the rivals over variants of an experiment.

Along the motion of rival i, the forces of rival j differ by  Δ = Φ_i p_i − Φ_j p_j.  What a refit of
the linear parameters that both have could take up is projected away; what is left is counted in the
noise that the sensors leave on the same equations. The effects in which they differ stay as they are
fitted, and the two motions of the closed loop are not compared, only the forces along one: an
approximation, good for rivals that fit the same logs. To ask which motion would show an effect, let one
rival have it and the other not.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.fading import faded
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.projection import solve_base
from pyident.logs.log import Log
from pyident.regression.regressor import generalised_forces
from pyident.regression.spectrum import Band, equations
from pyident.simulation.simulator import SimulateRivals

_SMOOTH = 31  # bins over which the noise of an equation is averaged


@dataclass(frozen=True)
class Separation:
    """name: of the variant that separates the rivals best;  score: distance of the closest two under it,
    in standard deviations of the sensors' noise;  scores: of every variant."""

    name: str
    score: float
    scores: Mapping[str, float]

    @property
    def sentence(self) -> str:
        if self.score < 1:
            return "none of the motions tried would separate them"
        return f"run {self.name}: there they differ by {self.score:.3g} standard deviations of sensor noise"


def separating(
    rivals: Sequence[Robot],
    variants: Mapping[str, Experiment],
    simulate: SimulateRivals,
    noise: Mapping[str, float],
    progress: Callable[[float], None] = lambda _: None,
) -> Separation:
    """The variant under which the two closest rivals are farthest apart.

    rivals     fitted robots, each with its own effect
    simulate   one frame per rival, in their order (pyident.simulation.simulator.rivals)
    noise      channel -> standard deviation of its sensor
    A variant that a rival cannot run is left out. Raises SimulationError when all are, ValueError for one
    rival alone.
    """
    if len(rivals) < 2:
        raise ValueError("separating needs two rivals or more")
    scores: dict[str, float] = {}
    failed: SimulationError | None = None
    for number, (name, experiment) in enumerate(variants.items(), start=1):
        try:
            logs = [Log(frame, name) for frame in simulate(experiment)]
        except SimulationError as error:
            failed = error
            continue
        scores[name] = min(
            distance(rivals[i], rivals[j], logs[i], noise)
            for i in range(len(rivals))
            for j in range(len(rivals))
            if i != j
        )
        progress(number / len(variants))
    if failed and not scores:
        raise failed
    best = max(scores, key=lambda name: scores[name])
    return Separation(best, scores[best], scores)


def distance(true: Robot, rival: Robot, log: Log, noise: Mapping[str, float]) -> float:
    """How far the forces along a log of `true` are from those of `rival` and any refit of what both have.

    In standard deviations of the sensors' noise.
    """
    part = faded(condition(log, rival))
    problem = equations(rival, [part], [log.period])[0]
    level = _noise_level(rival, log, noise, problem.band, part.use)
    difference = (_forces(true, log) - _forces(rival, log)) * part.use
    shared = [i for i, name in enumerate(rival.linear_parameters) if name in true.linear_parameters]
    asked = replace(problem, A=problem.A[:, :, shared], y=problem.band.transform(difference).T).over(level)
    return float(np.sqrt(solve_base([asked]).energy))


def _forces(robot: Robot, log: Log) -> np.ndarray:
    """(N, n) what the model's laws and bodies take along the log's motion."""
    motion = condition(log, robot).motion
    return generalised_forces(robot, motion, np.array(list(robot.linear_parameters.values())))


def _noise_level(
    robot: Robot, log: Log, noise: Mapping[str, float], band: Band, use: np.ndarray
) -> np.ndarray:
    """(n, E) rms that the sensors' noise leaves on each equation, smoothed over frequency."""
    noisy = log.noisier(noise, np.random.default_rng(0))
    torque = condition(noisy, robot).target - condition(log, robot).target
    left = band.transform((torque - _forces(robot, noisy) + _forces(robot, log)) * use).T
    power = (left[:, : band.bins] ** 2 + left[:, band.bins :] ** 2) / 2
    rms = np.sqrt(uniform_filter1d(power, min(_SMOOTH, band.bins), axis=1, mode="nearest"))
    return np.tile(np.maximum(rms, 1e-9 * rms.max()), (1, 2))
