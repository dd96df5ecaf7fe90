"""How much a model fails, where, and how much of that is the method's own doing."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexmodels.coordinate import deformation_of, is_deformation, joint_number, motor_of
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.comparison.bins import Bin, breakdown, replica_floor
from pyident.comparison.errors import Error, LogErrors
from pyident.comparison.fails import Fails, in_simulation
from pyident.comparison.model_against_replicas import Part, Progress, run_trial
from pyident.comparison.slow_noise import with_slow_noise
from pyident.comparison.traces import Bump, Trace, bumps, in_band, traces
from pyident.comparison.trial import TIP, Trial, on_trial
from pyident.comparison.without_simulation import parts_without_simulation, sentence_without_simulation
from pyident.conditioning.filters import thin
from pyident.logs.log import Log
from pyident.regression.spectrum import Floor
from pyident.rules.comparison import ComparisonRules
from pyident.rules.rules import RULES, Rules
from pyident.simulation.simulator import OpenPool


@dataclass(frozen=True)
class Comparison:
    """A model against logs.

    where       the part that fails most, None where nothing stands out
    structural  whether it stands out under refitted parameters too: the structure fails, not the values
    traces      every equation along every log
    bins, refitted   every part, under the model's own parameters and under refitted ones
    floor       what replicas leave of every equation over frequency
    tracks      whether the simulations track the measured motion, so that torques tell and positions do not
    """

    robot: str
    sentence: str
    where: Bin | None
    structural: bool
    logs: tuple[LogErrors, ...]
    bins: tuple[Bin, ...]
    refitted: tuple[Bin, ...]
    tracks: bool
    traces: tuple[Trace, ...] = ()
    floor: Floor | None = None

    @staticmethod
    def bumps(trace: Trace) -> list[Bump]:
        """Where a trace leaves what replicas show, the largest first."""
        return bumps(trace)

    def trace(self, log: str, coordinate: str, band: tuple[float, float] | None = None) -> Trace:
        """One equation on one log; band: of frequencies [Hz]. Raises LogError for a band without any."""
        found = next(t for t in self.traces if (t.log, t.coordinate) == (log, coordinate))
        if band is None or self.floor is None:
            return found
        row = [t.coordinate for t in self.traces if t.log == log].index(coordinate)
        return in_band(found, self.floor, row, band)

    def json(self) -> dict[str, Any]:
        """The contract of `compare --json`, and more."""
        return {
            "model": self.robot,
            "sentence": self.sentence,
            "where": _bin_json(self.where) | {"structural": self.structural} if self.where else None,
            "tracks_measured_motion": self.tracks,
            "logs": {log.log: log.json() for log in self.logs},
            "breakdown": [_bin_json(b) for b in self.bins],
            "breakdown_refitted": [_bin_json(b) for b in self.refitted],
        }


def compare(
    robot: Robot, logs: Sequence[Log], open_pool: OpenPool, progress: Progress, rules: Rules = RULES
) -> Comparison:
    """Hold an identified robot, with the parameters that it has, against logs.

    open_pool   robot -> context manager of processes that hold its FMU (`pipeline.FmuRuns`)
    rules          every threshold
    A model that cannot be simulated is judged by its equations alone. Raises LogError, BuildError.
    """
    trial = on_trial(robot, logs)
    try:
        with open_pool(trial.simulated) as workers:
            data, made = run_trial(trial, workers, progress, rules.comparison.replicas)
    except SimulationError as error:
        return _by_equations(trial, str(error))
    return compared(trial, data, made, rules.comparison)


def _by_equations(trial: Trial, reason: str) -> Comparison:
    """Of a model that cannot be simulated, and why it cannot."""
    data = parts_without_simulation(trial)
    errors = tuple(log_errors(trial, i, part, []) for i, part in enumerate(data))
    sentence = sentence_without_simulation(reason, errors)
    return Comparison(trial.robot.name, sentence, None, False, errors, (), (), trial.tracks)


def compared(
    trial: Trial, data: Sequence[Part], replicas: Sequence[Sequence[Part]], rules: ComparisonRules
) -> Comparison:
    """Errors, their floors and where they stand out most."""
    names = [r.log.source for r in trial.judged]
    errors = tuple(log_errors(trial, i, data[i], [parts[i] for parts in replicas]) for i in range(len(names)))
    short = [Path(n).name for n in names]
    own, refitted = (breakdown(trial.robot, data, replicas, short, r) for r in (False, True))
    fails = _fails(trial.robot, (own, refitted), replicas, short, errors, rules)
    if fails.where is not None and trial.paths:
        slow = with_slow_noise(trial, replicas)
        beside = tuple(breakdown(trial.robot, data, slow, short, r) for r in (False, True))
        fails = fails.beside(_fails(trial.robot, beside, slow, short, errors, rules))
    by_logs = trial.tracks or trial.robot.servo is not None  # whose fit is to positions anyway
    calm = fails.where is None and fails.doubted is None
    sentence = f"{fails.sentence(by_logs)} {in_simulation(trial, errors, calm)}"
    return Comparison(
        trial.robot.name,
        sentence,
        fails.where,
        fails.structural,
        errors,
        tuple(own),
        tuple(refitted),
        trial.tracks,
        tuple(t for i in range(len(names)) for t in _traces_of(trial, i, data[i], replicas, own)),
        replica_floor(replicas),
    )


def _traces_of(
    trial: Trial, i: int, data: Part, replicas: Sequence[Sequence[Part]], bins: Sequence[Bin]
) -> tuple[Trace, ...]:
    """Of the judged log number i."""
    coordinates = trial.robot.coordinates
    motors = [coordinates.index(motor_of(joint_number(name))) for name in coordinates]
    places = {name: at for at, name in enumerate(coordinates)}
    twists = [places.get(deformation_of(joint_number(name))) for name in coordinates]
    made = [parts[i] for parts in replicas]
    return traces(trial.judged[i].log.source, coordinates, data, made, bins, motors, twists)


def log_errors(trial: Trial, i: int, data: Part, replicas: Sequence[Part]) -> LogErrors:
    """Of the judged log number i."""
    robot, log = trial.robot, trial.judged[i].log
    equations = {}
    for c, name in enumerate(robot.coordinates):
        unit = _force_unit(robot, name)
        floor = _rms([_left(p, p.residual, c) for p in replicas])
        equations[name] = Error(
            _left(data, data.residual, c),
            _left(data, _signal(robot, data, c), c),
            floor,
            unit,
        )
    late = log.frame.iloc[-len(data.time) :]
    simulation = {
        name: Error(
            _rms(data.missed_where_counted(name)),
            _rms(late[name].to_numpy()),
            _rms([_rms(p.missed_where_counted(name)) for p in replicas]),
            _force_unit(robot, name) if name.endswith("tau") else _length_unit(robot, name),
        )
        for name in data.missed
    }
    tip = [simulation[name] for name in TIP if name in simulation]
    if len(tip) == len(TIP):
        move = late[list(TIP)].to_numpy() - late[list(TIP)].to_numpy().mean(axis=0)
        simulation["tip"] = Error(
            float(np.hypot.reduce([e.rmse for e in tip])),
            float(np.sqrt(np.mean(np.sum(move**2, axis=1)))),
            float(np.hypot.reduce([e.floor for e in tip])),
            "m",
        )
    return LogErrors(log.source, equations, simulation, data.time, data.missed)


def _left(part: Part, values: np.ndarray, c: int) -> float:
    """rms over the samples that are used, as the regression sees them."""
    factor = part.part.thinning
    used = part.part.use[::factor, c]
    thinned = thin(values[:, [c]], factor)[:, 0] * used
    return float(np.sqrt(np.sum(thinned**2) / max(float(np.sum(used)), 1e-300)))


def _signal(robot: Robot, part: Part, c: int) -> np.ndarray:
    """(N, n) whose column c is what the equation's error is measured by: motor torque or elastic moment."""
    stiffness = robot.q[c].stiffness
    if stiffness is None:
        return part.part.target * part.part.use
    return robot.parameters[stiffness] * part.part.motion.q


def _worst(
    bins: Sequence[Bin], errors: Sequence[LogErrors], chance: float, rules: ComparisonRules
) -> Bin | None:
    """The largest ratio among the parts that are no chance and that matter."""
    telling = [
        b
        for b in bins
        if b.deviations > rules.certain * chance
        and b.ratio > rules.matters
        and b.share > rules.carries
        and b.data_share > rules.samples
        and _excess(b.coordinate, errors) > rules.of_signal
    ]
    return max(telling, key=lambda b: b.ratio, default=None)


def _fails(
    robot: Robot,
    bins: Sequence[Sequence[Bin]],
    replicas: Sequence[Sequence[Part]],
    names: Sequence[str],
    errors: Sequence[LogErrors],
    rules: ComparisonRules,
) -> Fails:
    """Where a model fails most. bins: under its own parameters, and under refitted ones."""
    chances = (_chance(robot, replicas, names, refitted) for refitted in (False, True))
    values, structure = (_worst(b, errors, chance, rules) for b, chance in zip(bins, chances, strict=True))
    return Fails(values, structure)


def _chance(robot: Robot, replicas: Sequence[Sequence[Part]], names: Sequence[str], refitted: bool) -> float:
    """The largest deviation of any part of a replica from the others, taken for the data."""
    found = []
    for i, made in enumerate(replicas):
        others = [*replicas[:i], *replicas[i + 1 :]]
        found += [b.deviations for b in breakdown(robot, made, others, names, refitted)]
    return max(found)


def _excess(coordinate: str, errors: Sequence[LogErrors]) -> float:
    """rms beyond the floor, of the signal's, on the worst log."""
    found = [log.equations[coordinate] for log in errors]
    return max(np.sqrt(max(e.rmse**2 - e.floor**2, 0.0)) / max(e.signal, 1e-300) for e in found)


def _force_unit(robot: Robot, name: str) -> str:
    return "N" if _slides(robot, name) else "N m"


def _length_unit(robot: Robot, name: str) -> str:
    return "m" if name.startswith("tip") or _slides(robot, name) else "rad"


def _slides(robot: Robot, name: str) -> bool:
    """Whether a signal is measured along an axis."""
    return not is_deformation(name) and robot.joints[joint_number(name) - 1].kind == "prismatic"


def _rms(values: Any) -> float:
    """nan of nothing."""
    if len(values) == 0:
        return float("nan")
    return float(np.sqrt(np.mean(np.square(values))))


def _bin_json(b: Bin) -> dict[str, Any]:
    edges = {
        name: value if np.isfinite(value) else None for name, value in (("low", b.low), ("high", b.high))
    }
    return {
        "coordinate": b.coordinate,
        "joint": b.joint,
        "balance": b.balance,
        "kind": b.kind,
        "label": b.label,
        **edges,
        "unit": b.unit,
        "over_floor": b.ratio,
        "deviations": b.deviations,
        "share_of_excess": b.share,
        "share_of_data": b.data_share,
    }
