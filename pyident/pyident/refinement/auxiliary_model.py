"""The default estimator: instrumental variables from a simulated model, its own bias taken away.

The model found so far is simulated over each log's inputs. Its signals have no noise, so Φ of them is the
instrument (Janot, Vandanjon and Gautier 2014); and what its equations do not fulfil is the doing of samples
and means, not of noise, so that this residual is subtracted from the log's (indirect inference, Gourieroux et
al. 1993). At the fixed point log and simulation agree in every sum that the instruments take.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.filters import without_phase
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import condition
from pyident.estimation.estimate import estimate
from pyident.estimation.identify import Identified, identified, without_intervals
from pyident.estimation.instrumental_variables import (
    Logs,
    Rows,
    fading,
    solve_instrumental,
    spectral,
    unknown,
)
from pyident.estimation.least_squares import Solution
from pyident.estimation.physical import consistent, lower_bounds
from pyident.logs.log import Log
from pyident.refinement.noise_scatter import carries, noise_scatter
from pyident.refinement.remove_bias import seen
from pyident.refinement.stand_in import driven, smoothed
from pyident.regression.equations import Problem, predicted
from pyident.regression.reduced import Reduced
from pyident.simulation.replica import Repeat, repeats
from pyident.simulation.sensor_noise import sensor_noise
from pyident.simulation.simulator import OpenPool, Simulator, Workers

NAME = "instrumental variables with a simulated model"
START = "instrumental variables with filtered signals"
_ROUNDS = 8
_SETTLED = 0.1  # of a standard deviation: change at which the rounds end
_DAMPED = 0.5  # of the damping per stiffness that the hinges have in the middle: the least simulated
_LOW = (0.15, 0.04)  # of the Nyquist frequency: pass the first instruments; the better start is taken
_SHIFTS = 10.0  # times as much as scatter counts in a weight what samples do: it does not average out
_SMALL_STEP = 1e-4  # s
_FOLLOWS = 0.2  # of the motion: a simulation that misses more of it is no instrument
_EXCESS = 1.2  # times what the sensors' noise leaves in the instruments' band: more is not noise alone

Progress = Callable[[float], None]


@dataclass(frozen=True)
class _Data:
    """A log's equations in memory, everything in use: A (N, n, P), y (N, n), use (N, n)."""

    part: Conditioned
    A: np.ndarray
    y: np.ndarray
    use: np.ndarray


def identify_by_instruments(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress | None = None
) -> Identified:
    """Identify `robot`; its own parameters are never used. Raises LogError.

    open_pool   robot -> context manager of processes that hold its FMU
    Where the model cannot be simulated, or does not follow the logs, the estimate has no intervals.
    """
    parts = [condition(log, robot) for log in logs]
    reduced, plain = estimate(Problem(robot, tuple(parts)))
    data = [_in_memory(robot, part) for part in parts]
    lows = _LOW if carries(robot) else ()
    starts = [identified(robot, reduced, _started(robot, data, reduced, plain, low)) for low in lows]
    starts = starts or [identified(robot, reduced, plain)]
    best = starts[0]
    simulated, again = repeats(best.robot, logs)
    if not driven(robot):
        again = tuple(smoothed(r) for r in again)
    notes = tuple(r.note for r in again[:1] if r.note)
    try:
        with open_pool(simulated) as workers:
            best = _nearest(starts, again, workers)
            solution, reason = _rounds(robot, best, data, again, workers, progress)
    except SimulationError as error:
        solution, reason = best.solution, f"the model found cannot be simulated ({error})"
    if reason:
        name = START if carries(robot) else best.estimator
        note = f"{reason}; the estimate is that of {name} and has no intervals"
        return replace(without_intervals(best), estimator=name, notes=(*notes, note))
    return replace(identified(robot, reduced, solution), estimator=NAME, notes=notes)


def _nearest(starts: list[Identified], again: Sequence[Repeat], workers: Workers) -> Identified:
    """The start whose simulation follows the logs best. Raises SimulationError when none can be made."""
    errors: list[float] = []
    failure = None
    for start in starts:
        columns, values = start.reduced.columns, start.robot.linear_parameters.values()
        quiet = _simulable(start.robot, columns, np.array(list(values)))
        put_in = start.robot.parameters | dict(zip(columns, quiet.tolist(), strict=True))
        try:
            frames = _frames(again, workers, put_in)
            errors.append(max(_missed(r, frame) for r, frame in zip(again, frames, strict=True)))
        except SimulationError as error:
            errors.append(float("inf"))
            failure = error
    if failure is not None and not np.isfinite(errors).any():
        raise failure
    return starts[int(np.argmin(errors))]


def _started(robot: Robot, data: list[_Data], reduced: Reduced, plain: Solution, low: float) -> Solution:
    """Instruments from the log itself, of frequencies below `low`, where there is little noise."""
    from scipy.signal import butter

    sections = np.asarray(butter(4, low, output="sos"))

    def rows() -> list[Rows]:
        listed = []
        for d in data:
            share = _share(robot, d.use)
            listed.append(Rows(d.A, without_phase(sections, d.A * share[:, :, None]), d.y, share))
        return listed

    return solve_instrumental(rows, reduced, plain.weights, spectral(rows, plain.weights))


def _rounds(
    robot: Robot,
    best: Identified,
    data: list[_Data],
    again: Sequence[Repeat],
    workers: Workers,
    progress: Progress | None,
) -> tuple[Solution, str | None]:
    """The solution at which the rounds settle, or why there is none."""
    reduced, solution, rows = best.reduced, best.solution, []
    values, std = np.array(list(best.robot.linear_parameters.values())), best.solution.std
    fixed = {n: v for n, v in best.robot.parameters.items() if n not in best.robot.linear_parameters}
    for number in range(_ROUNDS):
        quiet = _simulable(robot, reduced.columns, values)
        put_in = dict(zip(reduced.columns, quiet.tolist(), strict=True))
        try:
            frames = _frames(again, workers, fixed | put_in)
        except SimulationError:
            quiet = consistent(robot, reduced, replace(solution, p=quiet))
            put_in = dict(zip(reduced.columns, quiet.tolist(), strict=True))
            frames = _frames(again, workers, fixed | put_in)
        missed = max(_missed(r, frame) for r, frame in zip(again, frames, strict=True))
        if not missed < _FOLLOWS:
            return solution, f"the simulated model misses {100 * missed:.0f} % of the motion"
        rows = [_rows(robot, d, frame, quiet) for d, frame in zip(data, frames, strict=True)]
        weights = _weights(data, rows, values)
        listed = _listing(rows)
        if number == 0:
            solution = solve_instrumental(listed, reduced, weights, spectral(listed, weights))
            std = solution.std
        else:
            solution = solve_instrumental(listed, reduced, weights, unknown, solution.rank)
        step = seen(solution, solution.p - values)
        values = values + step
        if progress:
            progress((number + 1) / _ROUNDS)
        if (np.abs(step)[~solution.open] <= _SETTLED * std[~solution.open]).all():
            break
    return _with_covariance(robot, data, again, rows, solution, reduced), None


def _listing(rows: list[Rows]) -> Logs:
    return lambda: rows


def _simulable(robot: Robot, names: tuple[str, ...], values: np.ndarray) -> np.ndarray:
    """Values under which a simulation is quiet: what noise makes of a small damping or friction may be none.

    A hinge that rings would fill the sums with what happens between the samples.
    """
    given = dict(zip(names, values.tolist(), strict=True))
    pairs = {d: d.replace(".d[", ".k[") for d in given if ".d[" in d}
    ratio = float(np.median([given[d] / given[k] for d, k in pairs.items() if given[k] > 0] or [0.0]))
    least = lower_bounds(robot) | {d: _DAMPED * ratio * given[k] for d, k in pairs.items()}
    return np.array([max(v, least.get(name, -np.inf)) for name, v in given.items()])


def _with_covariance(
    robot: Robot,
    data: list[_Data],
    again: Sequence[Repeat],
    rows: list[Rows],
    solution: Solution,
    reduced: Reduced,
) -> Solution:
    """The noise of the sensors through the equations, and what there is beyond it by its spectrum."""
    if not carries(robot):
        by_spectrum = spectral(_listing(rows), solution.weights)
        return solve_instrumental(_listing(rows), reduced, solution.weights, by_spectrum, solution.rank)
    noise = sensor_noise(robot, [r.log for r in again], solution.p)

    def scatter(turn: np.ndarray, p: np.ndarray) -> np.ndarray:
        parts = [
            noise_scatter(robot, d.part, r, p, solution.weights, turn, noise, a.log.period)
            for d, r, a in zip(data, rows, again, strict=True)
        ]
        from_noise = np.sum(parts, axis=0)
        ratio = _beyond(robot, data, again, rows, p, noise, solution.weights)
        if ratio < _EXCESS:
            return from_noise
        return from_noise + (1 - 1 / ratio) * spectral(_listing(rows), solution.weights)(turn, p)

    return solve_instrumental(_listing(rows), reduced, solution.weights, scatter, solution.rank)


def _beyond(
    robot: Robot,
    data: list[_Data],
    again: Sequence[Repeat],
    rows: list[Rows],
    p: np.ndarray,
    noise: dict[str, float],
    weights: np.ndarray,
) -> float:
    """Power of the residual over that of drawn noise, in the lower half of the band where instruments are."""
    rng, left, drawn = np.random.default_rng(0), 0.0, 0.0
    for d, r, a in zip(data, rows, again, strict=True):
        frame = a.log.frame.copy()
        for name, sigma in noise.items():
            frame[name] = frame[name] + sigma * rng.standard_normal(len(frame))
        more = _in_memory(robot, condition(replace(a.log, frame=frame), robot))
        change = (more.y - d.y) - (predicted(more.A, p) - predicted(d.A, p))
        left += _low_power((r.y - predicted(r.A, p)) * r.share * weights)
        drawn += _low_power(change * r.share * weights)
    return left / max(drawn, 1e-300)


def _low_power(values: np.ndarray) -> float:
    spectrum = np.abs(np.fft.rfft(values, axis=0)) ** 2
    return float(spectrum[: len(spectrum) * 2 // 5].sum())


def _simulated(fmu: Simulator, again: Repeat, parameters: dict[str, float]) -> pd.DataFrame:
    try:
        return again.simulated(fmu.simulate, parameters)
    except SimulationError:  # what a poor start makes of a small inertia may vibrate fast
        return again.simulated(fmu.simulate, parameters | {"solver.step": _SMALL_STEP})


def _frames(again: Sequence[Repeat], workers: Workers, parameters: dict[str, float]) -> list[pd.DataFrame]:
    jobs = [workers.submit(_simulated, r, parameters) for r in again]
    return [job.result() for job in jobs]


def _missed(again: Repeat, frame: pd.DataFrame) -> float:
    """The largest share of a joint's motion that the simulation misses."""
    names = [f"joint{k}.e" for k in range(1, again.plan.reference.shape[1] + 1)]
    measured, made = again.log.signals(names), frame[names].to_numpy()
    moved = measured.std(axis=0)
    moved = np.maximum(moved, 1e-3 * moved.max())
    missed = np.std(measured - made, axis=0) / moved
    return float(missed.max()) if np.isfinite(missed).all() else float("inf")


def _rows(robot: Robot, data: _Data, frame: pd.DataFrame, p: np.ndarray) -> Rows:
    """Instruments from a simulation, and the log's torques without what the simulation's equations leave."""
    made = _in_memory(robot, condition(Log(frame, "simulation"), robot))
    share = _share(robot, data.use * made.use)
    left = made.y - predicted(made.A, p) if driven(robot) else 0.0
    return Rows(data.A, made.A, data.y - left, share)


def _share(robot: Robot, use: np.ndarray) -> np.ndarray:
    return fading(use) if robot.settings.processing.decimate == 1 else use


def _weights(data: list[_Data], rows: list[Rows], p: np.ndarray) -> np.ndarray:
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


def _in_memory(robot: Robot, part: Conditioned) -> _Data:
    problem = Problem(robot, (replace(part, use=np.ones_like(part.use)),))
    blocks = [(A.copy(), y.copy()) for A, y in problem.blocks()]
    A, y = (np.concatenate(x) for x in zip(*blocks, strict=True))
    use = part.use[:: part.thinning]
    return _Data(part, A, y, use)
