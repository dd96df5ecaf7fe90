"""Intervals of the instrumental estimate: noise of the sensors, motion that noise makes, and the simulation.

Three parts. The noise of the sensors goes through the equations. What the residual has beyond it, at
a frequency of an equation, counts by its spectrum. And the simulation from which the estimate takes what
samples and means do rests on the estimate itself: with p̂ = g(p̂) and g' its derivative, an error of g
becomes (1 − g')⁻¹ times as large; what the simulation was not given as it was estimated counts as an error.
Dampings of hinges that vibrate faster than the log is sampled get no interval: none that was tried held.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.conditioning.motion import Motion
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import (
    MomentEquations,
    Rows,
    beyond_noise,
    smoothed_power,
    spectral,
)
from pyident.estimation.least_squares import Solution
from pyident.logs.log import Log
from pyident.refinement.noise_scatter import carries, noise_scatter
from pyident.refinement.remove_bias import seen
from pyident.refinement.simulated_rows import Repeated, every, in_memory, left_of, simulated
from pyident.refinement.stand_in import driven
from pyident.regression.natural_frequencies import natural_frequencies
from pyident.regression.regressor import predicted
from pyident.simulation.replica import Repeat
from pyident.simulation.sensor_noise import sensor_noise
from pyident.simulation.simulator import Simulator, Workers, runs_at_once

_FASTEST = 0.8  # of the Nyquist frequency: what vibrates faster is seen by its aliases only


def with_covariance(
    logs: Repeated, rows: list[Rows], equations: MomentEquations, solution: Solution
) -> Solution:
    """The noise of the sensors through the equations, and what there is beyond it by its spectrum."""
    robot = logs.robot
    if not carries(robot):
        return equations.solve(spectral(every(rows), solution.weights), solution.rank)
    noise = sensor_noise(robot, [r.log for r in logs.again], solution.p)

    def scatter(turn: np.ndarray, p: np.ndarray) -> np.ndarray:
        beyond = _beyond(logs, rows, p, noise)
        total = spectral(every(rows), solution.weights, beyond)(turn, p)
        for d, r, a in zip(logs.data, rows, logs.again, strict=True):
            total += noise_scatter(robot, d.part, r, p, solution.weights, turn, noise, a.log.period)
        return total

    return equations.solve(scatter, solution.rank)


def _beyond(logs: Repeated, rows: list[Rows], p: np.ndarray, noise: dict[str, float]) -> list[np.ndarray]:
    """Per log and frequency of the transform: share of the residual's amplitude that no sensor's noise is.

    A hinge that the controller shakes with the encoders' noise rings between the samples; near reversals
    friction changes its sign with the noise. Both are motion, which no noise of a sensor tells of.
    """
    rng, out = np.random.default_rng(0), []
    for d, r, a in zip(logs.data, rows, logs.again, strict=True):
        frame = a.log.frame.copy()
        for name, sigma in noise.items():
            frame[name] = frame[name] + sigma * rng.standard_normal(len(frame))
        more = in_memory(logs.robot, condition(replace(a.log, frame=frame), logs.robot))
        change = (more.y - d.y) - (predicted(more.A, p) - predicted(d.A, p))
        out.append(beyond_noise(*(smoothed_power(v * r.share) for v in (r.residual(p), change))))
    return out


def simulation_slope(
    logs: Repeated,
    equations: MomentEquations,
    solution: Solution,
    std: np.ndarray,
    workers: Workers,
    put_in: Mapping[str, float],
    held: np.ndarray,
) -> np.ndarray:
    """(P, P) derivative of g, whose value at `put_in` is `solution`, by the parameters of the simulation.

    std      (P,) standard deviations: the steps of the differences
    put_in   every parameter of the simulation that gave the instruments
    held     (P,) which of them the simulation had otherwise than they were estimated
    Of what is simulated, the dampings of hinges change g: they say how much rings between the samples.
    Raises SimulationError.
    """
    names = logs.reduced.columns
    slope = np.zeros((len(names), len(names)))
    if not driven(logs.robot):  # then nothing of the simulation's equations is in the targets
        return slope
    asked = [j for j, name in enumerate(names) if ".d[" in name and 0 < std[j] < np.inf]
    steps = {j: -0.5 * put_in[names[j]] * held[j] or float(std[j]) for j in asked}  # held at zero: upwards
    changed = [{**put_in, names[j]: put_in[names[j]] + step} for j, step in steps.items()]
    together = max(1, runs_at_once(max(len(r.log.frame) for r in logs.again)) // len(logs.again))
    jobs = [
        workers.submit(_shifts, logs.robot, logs.again, changed[at : at + together])
        for at in range(0, len(changed), together)
    ]
    shifts = [shift for job in jobs for shift in job.result()]
    for (j, step), shift in zip(steps.items(), shifts, strict=True):
        there = equations.change([d.y - s for d, s in zip(logs.data, shift, strict=True)], solution.rank)
        slope[:, j] = seen(solution, there - solution.p) / step
    return slope


def through_simulation(
    solution: Solution, slope: np.ndarray, put_in: np.ndarray, held: np.ndarray
) -> Solution:
    """The covariance of the fixed point p̂ = g(p̂), where `solution` has that of g.

    slope, held   as of `simulation_slope`
    put_in        (P,) linear parameters of the simulation
    """
    grown = np.linalg.inv(np.eye(len(slope)) - np.where(held, 0.0, slope))
    error = np.where(held, (put_in - solution.p) ** 2 + np.diag(solution.covariance), 0.0)
    covariance = grown @ (solution.covariance + (slope * error) @ slope.T) @ grown.T
    return replace(solution, covariance=covariance)


def ringing(robot: Robot, motions: Sequence[Motion], period: float) -> list[str]:
    """Dampings of the hinges that vibrate faster than logs of this period can follow; robot: fitted."""
    limit = _FASTEST / (2 * period)
    fast = {c for motion in motions for c, f in natural_frequencies(robot, motion).items() if f > limit}
    return sorted(c.replace(".eps[", ".d[") for c in fast)


def without_intervals_of(solution: Solution, columns: Sequence[str], names: Sequence[str]) -> Solution:
    """The solution without the covariance of the named parameters."""
    covariance = solution.covariance.copy()
    told = [columns.index(name) for name in names]
    covariance[told, :] = covariance[:, told] = np.nan
    return replace(solution, covariance=covariance)


def _shifts(
    fmu: Simulator, robot: Robot, again: Sequence[Repeat], sets: Sequence[Mapping[str, float]]
) -> list[list[np.ndarray]]:
    """Per set and log (N, n): what a simulation's samples and means leave of its own equations [N m]."""
    names = list(robot.linear_parameters)
    made = simulated(fmu, again, sets)

    def left(run: tuple[int, int]) -> np.ndarray:
        number, log = run
        p = np.array([sets[number][name] for name in names])
        return left_of(robot, condition(Log(made[number][log], "simulation"), robot), p)

    logs = range(len(again))
    shifts = gathered(left, [(number, log) for number in range(len(sets)) for log in logs])
    return [shifts[at : at + len(again)] for at in range(0, len(shifts), len(again))]
