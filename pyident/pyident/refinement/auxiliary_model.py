"""The default estimator: instrumental variables from a simulated model, its own bias taken away.

The model found so far is simulated over each log's inputs. Its signals have no noise, so Φ of them is the
instrument (Janot, Vandanjon and Gautier 2014); and what its equations do not fulfil is the doing of samples
and means, not of noise, so that this residual is subtracted from the log's (indirect inference, Gourieroux et
al. 1993). At the fixed point log and simulation agree in every sum that the instruments take.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.conditioning.filters import without_phase
from pyident.conditioning.weak_form import condition
from pyident.estimation.base_parameters import base_parameters
from pyident.estimation.estimator import Estimate, weighted
from pyident.estimation.identify import (
    Identified,
    disagreements,
    identified,
    near,
    soft_hinges,
    without_intervals,
)
from pyident.estimation.instrumental_variables import (
    Rows,
    moment_equations,
    solve_instrumental,
    spectral,
    unknown,
)
from pyident.estimation.least_squares import Solution
from pyident.estimation.physical import consistent
from pyident.logs.log import Log
from pyident.refinement.fixed_point import FixedPoint
from pyident.refinement.instrumental_covariance import (
    ringing,
    simulation_slope,
    through_simulation,
    with_covariance,
    without_intervals_of,
)
from pyident.refinement.noise_scatter import carries
from pyident.refinement.remove_bias import seen
from pyident.refinement.simulated_rows import (
    Data,
    Repeated,
    every,
    faded,
    in_memory,
    rows_of,
    simulable,
    simulated,
    simulations,
)
from pyident.refinement.stand_in import driven, smoothed
from pyident.regression.equations import Problem
from pyident.regression.regressor import predicted
from pyident.simulation.replica import Repeat, repeats
from pyident.simulation.simulator import OpenPool, Workers

NAME = "instrumental variables with a simulated model"
START = "instrumental variables with filtered signals"
_ROUNDS = 8
_NEAR = 3  # round from which on the steps are Newton's: there the simulation's own slope is measured
_SETTLED = 0.2  # of a standard deviation: change at which the rounds end
_LOW = (0.15, 0.04)  # of the Nyquist frequency: pass the first instruments; the better start is taken
_SHIFTS = 10.0  # times as much as scatter counts in a weight what samples do: it does not average out
_FOLLOWS = 0.2  # of the motion: a simulation that misses more of it is no instrument

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
    Where the model cannot be simulated, or does not follow the logs, the estimate has no intervals.
    """
    parts = [condition(log, robot) for log in logs]
    plain = weighted(Problem(robot, tuple(parts)))
    reduced = plain.reduced
    data = gathered(lambda part: in_memory(robot, part), parts)
    lows = _LOW if carries(robot) else ()
    solutions = gathered(lambda low: _started(robot, data, plain, low), lows)
    starts = [identified(robot, reduced, solution) for solution in solutions]
    if not starts:
        solution = plain.solution if prior is None else coloured(robot, data, plain)
        starts = [identified(robot, reduced, solution)]
    if prior is not None:
        starts = [near(start, prior) for start in starts]
        starts = [_with_bodies_of(prior, starts[0]), *starts]
    best = starts[0]
    followed, again = repeats(best.robot, logs)
    if not driven(robot):
        again = tuple(smoothed(r) for r in again)
    notes = tuple(r.note for r in again[:1] if r.note)
    try:
        with open_pool(followed) as workers:
            best = _nearest(starts, again, workers)
            solution, reason = _rounds(Repeated(robot, data, again, reduced), best, workers, progress, prior)
    except SimulationError as error:
        solution, reason = best.solution, f"the model found cannot be simulated ({error})"
    if reason:
        best = starts[1] if prior is not None and best is starts[0] else best
        name = START if carries(robot) else best.estimator
        note = f"{reason}; the estimate is that of {name} and has no intervals"
        return replace(without_intervals(best), estimator=name, notes=(*notes, note, *best.notes))
    found = identified(robot, reduced, solution)
    if prior is not None:
        found = near(found, prior)
        notes = (*notes, *found.notes, *disagreements(found))
    fast = ringing(found.robot, data, max(log.period for log in logs))
    if fast:
        told = without_intervals_of(solution, reduced.columns, fast)
        found = replace(found, solution=told, base=base_parameters(reduced, told))
        why = "their hinges vibrate faster than the samples can follow"
        notes = (*notes, f"no interval for {', '.join(fast)}: {why}")
    return replace(found, estimator=NAME, notes=notes)


def _with_bodies_of(prior: Robot, start: Identified) -> Identified:
    """A start with a prior's links and hinges: a noisy deformation spoils those of a regression first."""
    own = start.robot.linear_parameters
    known = {
        n: v
        for n, v in prior.parameters.items()
        if n in own and (n.startswith("link") or ".k[" in n or ".d[" in n)
    }
    return replace(start, robot=start.robot.with_parameters(known))


def _nearest(starts: list[Identified], again: Sequence[Repeat], workers: Workers) -> Identified:
    """The start whose simulation follows the logs best. Raises SimulationError when none can be made."""
    errors: list[float] = []
    failure = None
    sets = [_put_in(start) for start in starts]
    try:
        runs = iter(workers.submit(simulated, again, sets).result())
    except SimulationError:  # of one of them
        runs = None
    for parameters in sets:
        try:
            frames = next(runs) if runs else simulations(again, workers, parameters)
            errors.append(max(_missed(r, frame) for r, frame in zip(again, frames, strict=True)))
        except SimulationError as error:
            errors.append(float("inf"))
            failure = error
    if failure is not None and not np.isfinite(errors).any():
        raise failure
    return starts[int(np.argmin(errors))]


def _put_in(start: Identified) -> dict[str, float]:
    """Every parameter of a simulation of the start."""
    columns, values = start.reduced.columns, start.robot.linear_parameters.values()
    quiet = simulable(start.robot, columns, np.array(list(values)))
    return start.robot.parameters | dict(zip(columns, quiet.tolist(), strict=True))


def coloured(robot: Robot, data: list[Data], plain: Estimate) -> Solution:
    """The solution of a regression with a covariance under residuals that have a memory."""
    rows = [Rows(d.A, d.A, d.y, d.use.astype(float)) for d in data]
    solution = plain.solution
    turn = solution.seen / solution.singular_values[: solution.rank] / solution.scale[:, None]
    meat = spectral(every(rows), solution.weights)(turn, solution.p)
    return replace(solution, covariance=turn @ meat @ turn.T)


def _started(robot: Robot, data: list[Data], plain: Estimate, low: float) -> Solution:
    """Instruments from the log itself, of frequencies below `low`, where there is little noise."""
    from scipy.signal import butter

    sections = np.asarray(butter(4, low, output="sos"))

    rows = []
    for d in data:
        share = faded(robot, d.use)
        Z = np.zeros_like(d.A)
        for c, columns in enumerate(d.columns):
            Z[:, c, columns] = without_phase(sections, d.A[:, c][:, columns] * share[:, c, None])
        rows.append(Rows(d.A, Z, d.y, share))
    weights = plain.solution.weights
    return solve_instrumental(every(rows), plain.reduced, weights, spectral(every(rows), weights))


def _rounds(
    logs: Repeated,
    best: Identified,
    workers: Workers,
    progress: Progress | None,
    prior: Robot | None,
) -> tuple[Solution, str | None]:
    """The solution at which the rounds settle, or why there is none."""
    robot, data, again, reduced = logs.robot, logs.data, logs.again, logs.reduced
    solution, rows, put_in = best.solution, [], {}
    values, std = np.array(list(best.robot.linear_parameters.values())), best.solution.std
    fixed = {n: v for n, v in best.robot.parameters.items() if n not in best.robot.linear_parameters}
    held, quiet, slope, newton = np.zeros(len(values), bool), values, None, None
    for number in range(_ROUNDS):
        hinges = {} if prior is None else soft_hinges(reduced.columns, replace(solution, p=values), prior)
        quiet = simulable(robot, reduced.columns, values, hinges)
        put_in = fixed | dict(zip(reduced.columns, quiet.tolist(), strict=True))
        try:
            frames = simulations(again, workers, put_in)
        except SimulationError:
            quiet = consistent(robot, reduced, replace(solution, p=quiet), prior)
            put_in = fixed | dict(zip(reduced.columns, quiet.tolist(), strict=True))
            try:
                frames = simulations(again, workers, put_in)
            except SimulationError:
                if not rows or driven(robot):
                    raise
                break  # nothing of a simulation but its instruments is in the estimate: the last ones do
        held = quiet != values
        missed = max(_missed(r, frame) for r, frame in zip(again, frames, strict=True))
        if not missed < _FOLLOWS:
            return solution, f"the simulated model misses {100 * missed:.0f} % of the motion"
        rows = gathered(partial(_rows_of, robot, quiet), list(zip(data, frames, strict=True)))
        equations = moment_equations(every(rows), reduced, _weights(data, rows, values))
        if number == 0:
            solution = equations.solve(spectral(equations.logs, equations.weights))
            std = solution.std
        else:
            solution = equations.solve(unknown, solution.rank)
        step = seen(solution, solution.p - values)
        if number == _NEAR:
            slope = simulation_slope(logs, equations, solution, std, workers, put_in, held)
            newton = FixedPoint(np.eye(len(slope)) - np.where(held, 0.0, slope), std)
        if newton is not None:
            step = newton.step(step)
        values = values + step
        if progress:
            progress((number + 1) / _ROUNDS)
        if (np.abs(step)[~solution.open] <= _SETTLED * std[~solution.open]).all():
            break
    known = with_covariance(logs, rows, equations, solution)
    if slope is None:
        slope = simulation_slope(logs, equations, known, known.std, workers, put_in, held)
    return through_simulation(known, slope, quiet, held), None


def _rows_of(robot: Robot, p: np.ndarray, log: tuple[Data, pd.DataFrame]) -> Rows:
    return rows_of(robot, *log, p)


def _missed(again: Repeat, frame: pd.DataFrame) -> float:
    """The largest share of a joint's motion that the simulation misses."""
    names = [f"joint{k}.e" for k in range(1, again.plan.reference.shape[1] + 1)]
    measured, made = again.log.signals(names), frame[names].to_numpy()
    moved = measured.std(axis=0)
    moved = np.maximum(moved, 1e-3 * moved.max())
    missed = np.std(measured - made, axis=0) / moved
    return float(missed.max()) if np.isfinite(missed).all() else float("inf")


def _weights(data: list[Data], rows: list[Rows], p: np.ndarray) -> np.ndarray:
    """One over what each coordinate's equations leave: of the log, and of the simulation.

    Noise alone would give all weight to equations of deformations, which zero solves: what samples and means
    do to them would be taken for less stiffness, and taking it away again would raise their noise.
    """
    squares = np.zeros(len(rows[0].y[0]))
    for d, r in zip(data, rows, strict=True):
        scatter, shift = (r.y - predicted(r.A, p)) * r.share, (d.y - r.y) * r.share
        squares += np.sum(scatter**2 + (_SHIFTS * shift) ** 2, axis=0)
    rms = np.sqrt(squares / sum(len(r.y) for r in rows))
    return 1 / np.maximum(rms, 1e-6 * rms.max())
