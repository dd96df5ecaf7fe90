"""Add an effect to a robot, or correct its description: fit it, simulate it, and keep it only if it holds.

The equations are judged by the gate of a diagnosis (`diagnosis.search.gate`), the simulation by its error on
data that were not used: the FMU runs under the log's reference. Without references it tracks the measured
motion; positions then agree in any case, and it is the motor torques that it needs which tell. These hold
what a stand-in for the loop does, so that it is enough if they do not rise with an effect that takes as much
as a name needs. Linear parameters come from the regression with its bias removed, nonlinear ones and
corrections from the search.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from flexmodels.coordinate import is_motor, is_torque, signal_of
from flexmodels.inputs import SimulationError
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.comparison.bins import mean_square_over_floor
from pyident.comparison.errors import Error, LogErrors
from pyident.comparison.model_against_replicas import Progress
from pyident.comparison.trial import Trial
from pyident.diagnosis.base.candidates import law_of
from pyident.diagnosis.coefficients import loosely_told
from pyident.extension.ask import Asked, ask
from pyident.extension.beside import begun
from pyident.extension.extended_robot import Correction, extended_robot, known_beforehand, require_new
from pyident.extension.fit import Fit, fit_to
from pyident.extension.split import split
from pyident.extension.waterfall import Step
from pyident.logs.log import Log
from pyident.regression.descriptions import describes
from pyident.rules.rules import RULES, Rules
from pyident.simulation.simulator import OpenPool

_SCATTER = 0.1  # of a law's largest coefficient: by so much noise may bring one beyond its bound


@dataclass(frozen=True)
class Extended:
    """The outcome of adding an effect.

    base, robot      without and with the effect, both fitted to the same logs
    before, after    their errors on held-out data, above the floor of the model with the effect
    waterfall        torque or moment where the effect acts, then the simulation, on held-out and fitted data
    gains            relative fall of the mean square error: equations, simulation
    reason           why the effect is refused; empty: it is accepted
    asked            what the gate of a diagnosis says, with its numbers
    correction       of the description; None where a law was added
    undetermined     parameters of the law that logs do not tell by themselves, whatever it takes with them
    """

    base: Robot
    robot: Robot
    before: tuple[LogErrors, ...]
    after: tuple[LogErrors, ...]
    waterfall: tuple[Step, ...]
    gains: tuple[float, float]
    reason: str
    asked: Asked
    correction: Correction | None = None
    undetermined: tuple[str, ...] = ()

    @property
    def accepted(self) -> bool:
        return not self.reason

    def json(self) -> dict[str, Any]:
        """For machines: whether it is accepted, why not, its parameters, errors on held-out data."""
        new = {n: v for n, v in self.robot.parameters.items() if n not in self.base.parameters}
        units = self.robot.units
        known = {n: n not in self.undetermined for n in new}
        parameters = {n: {"value": v, "unit": units[n], "determined": known[n]} for n, v in new.items()}
        if self.correction:
            parameters |= self.correction.json()
        return {
            "accepted": self.accepted,
            "reason": self.reason,
            "parameters": parameters,
            "gate": self.asked.json(),
            "mean_square_fall_percent": {
                "equations": 100 * self.gains[0],
                "simulation": 100 * self.gains[1],
            },
            "waterfall": [asdict(step) for step in self.waterfall],
            "before": {log.log: log.json() for log in self.before},
            "after": {log.log: log.json() for log in self.after},
        }


def add_effect(
    robot: Robot,
    joint: int,
    effect: str,
    logs: Sequence[Log],
    heldout: Sequence[Log],
    open_pool: OpenPool,
    progress: Progress,
    rules: Rules = RULES,
) -> Extended:
    """Fit `robot` with one more law at `joint` (from 1) and judge it on data that were held out.

    open_pool   robot -> context manager of processes that hold its FMU (`pipeline.FmuRuns`)
    Raises RobotError where the law cannot act, LogError, and what the simulation raises.
    """
    require_new(robot, joint, effect)
    parts = split(logs, heldout, rules)
    rest, replicas = _share(progress, 0.6, 1.0), rules.replicas.trial

    def judged(model: Robot, told: Progress) -> Fit:
        return fit_to(model, parts, open_pool, rules, told, replicas)

    known = known_beforehand(robot, joint, effect)
    ahead = None if known is None else begun(judged, known, lambda _: None)
    base = fit_to(robot, parts, open_pool, rules, progress)
    progress(0.2)
    asked = ask(base.asked, joint, effect, parts.unseen, open_pool, _share(progress, 0.2, 0.5))
    wider, correction = extended_robot(robot, asked)
    try:
        new = judged(wider, rest) if ahead is None else ahead.result()
    except SimulationError as error:
        return _not_simulated(judged(robot, rest), wider, asked, correction, error)
    return _judged(base.beside(new.replicas), new, asked, correction)


def _loose(asked: Asked) -> tuple[str, ...]:
    """Parameters of a law that its logs do not determine."""
    c, std = asked.candidate, asked.found.gain.std
    if c.describes:
        return ()
    linear = [p.name for p in law_of(asked.search.robot, c).linear]
    names = [parameter_name(c.joint, c.effect, name) for name in (*linear, *dict(c.nonlinear))]
    loose = loosely_told(asked.search, (), c)
    loose[: len(std)] |= np.isinf(std)
    return tuple(name for name, unknown in zip(names, loose.tolist(), strict=False) if unknown)


def _share(progress: Progress, start: float, end: float) -> Progress:
    return lambda fraction: progress(start + (end - start) * fraction)


def _not_simulated(
    base: Fit, wider: Robot, asked: Asked, correction: Correction | None, error: SimulationError
) -> Extended:
    """A law that the logs show so badly that no model with it can be simulated."""
    errors, joint, effect = base.unseen, asked.candidate.joint, asked.candidate.effect
    rows = _acts_on(wider, joint, effect)
    steps = tuple(step for row in rows for step in _steps("equations", row, base, base))
    reason = f"{effect} at joint {joint} is refused: the model fitted with it cannot be simulated ({error})"
    found = base.trial.robot, wider, errors, errors, steps, (0.0, 0.0)
    return Extended(*found, reason, asked, correction, _loose(asked))


def _judged(base: Fit, new: Fit, asked: Asked, correction: Correction | None) -> Extended:
    joint, effect = asked.candidate.joint, asked.candidate.effect
    before, after = base.unseen, new.unseen
    rows = _acts_on(new.trial.robot, joint, effect)
    channels = _telling(base.trial, before)
    at = [base.trial.robot.coordinates.index(row) for row in rows]
    floors = [parts[new.fitted :] for parts in new.replicas]
    left = [mean_square_over_floor(fit.data[fit.fitted :], floors, at) for fit in (base, new)]
    own = _of_joints(base.trial, rows, channels)
    missed = [_mean_square(errors, after, own) for errors in (before, after)]
    gains = (1 - left[1] / left[0], 1 - missed[1] / missed[0])
    shown = ["tip"] if all("tip" in log.simulation for log in before) and not base.trial.tracks else channels
    wanted = [("equations", name) for name in rows] + [("simulation", name) for name in shown]
    steps = [step for kind, name in wanted for step in _steps(kind, name, base, new)]
    word = effect.replace("[", "_").removesuffix("]")
    name = f"{base.trial.robot.name.removesuffix('_identified')}_{word}{joint}"
    robot = replace(new.trial.robot, name=name)
    lacking, hidden = _no_such_law(robot, joint, effect), missed[1] <= 1.0
    reason = _reason(asked, gains, base.trial.tracks, hidden, base.setting.rules, lacking)
    found = base.trial.robot, robot, before, after, tuple(steps), gains
    return Extended(*found, reason, asked, correction, _loose(asked))


def _acts_on(robot: Robot, joint: int, effect: str) -> list[str]:
    """Coordinates on whose equations the law acts."""
    if describes(effect):
        return list(robot.coordinates)
    named = {str(q) for q in robot.joints[joint - 1].law(effect).forces}
    wanted = {signal_of(joint, name) for name in named}
    return [c.name for c in robot.q if c.signal in wanted]


def _telling(trial: Trial, errors: Sequence[LogErrors]) -> list[str]:
    """Signals by which the simulation is judged: motor torques where it tracks the measured motion."""
    names = list(errors[0].simulation)
    if trial.tracks:
        return [n for n in names if is_torque(n)]
    return [n for n in names if not is_torque(n) and n != "tip"]


def _of_joints(trial: Trial, rows: Sequence[str], channels: Sequence[str]) -> list[str]:
    """Torques of the joints on whose equations a law acts; where the motion is simulated, all channels."""
    own = [n for n in channels if any(row.startswith(n.removesuffix("tau")) for row in rows)]
    return own if own and trial.tracks else list(channels)


def _mean_square(errors: Sequence[LogErrors], floors: Sequence[LogErrors], names: Sequence[str]) -> float:
    """Of the simulation, over logs and signals, each over its floor."""
    pairs = [
        (e.simulation[n].rmse, f.simulation[n].floor)
        for e, f in zip(errors, floors, strict=True)
        for n in names
    ]
    return float(np.mean([(rmse / max(level, 1e-300)) ** 2 for rmse, level in pairs]))


def _steps(kind: str, name: str, base: Fit, new: Fit) -> list[Step]:
    """On held-out data, then on fitted ones."""
    steps = [_step(kind, name, base.unseen, new.unseen)]
    before, after = base.seen, new.seen
    if before and all(name in getattr(log, kind) for log in (*before, *after)):
        steps.append(replace(_step(kind, name, before, after), data="fitted"))
    return steps


def _step(kind: str, name: str, before: Sequence[LogErrors], after: Sequence[LogErrors]) -> Step:
    listed: list[tuple[Error, Error]] = [
        (getattr(b, kind)[name], getattr(a, kind)[name]) for b, a in zip(before, after, strict=True)
    ]
    earlier, later, floor = (
        float(np.sqrt(np.mean(np.square(v))))
        for v in ([b.rmse for b, _ in listed], [a.rmse for _, a in listed], [a.floor for _, a in listed])
    )
    what = "simulated" if kind == "simulation" else "torque" if is_motor(name) else "moment"
    return Step(f"{what} {name}", listed[0][0].unit, earlier, later, floor)


def _reason(
    asked: Asked, gains: tuple[float, float], tracks: bool, hidden: bool, rules: Rules, no_such_law: str
) -> str:
    """What the gate of a diagnosis says against an effect, its values and the simulation; empty: nothing.

    hidden   whether the simulation misses no more than its floor, so that a change within it says nothing
    """
    gate, least, c = asked.admission, rules.extension.least_gain, asked.candidate
    what = "the torque that the simulation needs" if tracks else "the simulation"
    said = [text for text in (gate.reason, no_such_law) if text]
    excused = tracks and not said and gate.share >= rules.search.explained[0]
    if gains[1] < (-least if excused else least) and not (excused and hidden):
        said.append(f"on held-out data the error of {what} {_change(gains[1], least)}")
    elif excused and max(gains) <= 0:
        said.append("on held-out data no error falls")
    return f"{c.effect} at joint {c.joint} is refused: {'; '.join(said)}." if said else ""


def _no_such_law(robot: Robot, joint: int, effect: str) -> str:
    """Which fitted coefficient is none that the law may have, by more than scatter; empty: none is."""
    if describes(effect):
        return ""
    law = robot.joints[joint - 1].law(effect)
    values = {p: robot.parameters[parameter_name(joint, effect, p.name)] for p in law.linear}
    if not any(values.values()):
        return "fitted beside all else, nothing is left of it"
    scatter = _SCATTER * max((abs(v) for v in values.values()), default=0.0)
    for p, value in values.items():
        if not p.lower - scatter <= value <= p.upper + scatter:
            bound = f"below {p.lower:g}" if value < p.lower else f"above {p.upper:g}"
            return f"its {p.name} of {value:.3g} {p.unit if p.unit != '1' else ''}".rstrip() + f" is {bound}"
    return ""


def _change(value: float, least: float) -> str:
    """Of a mean square, said of its root."""
    percent = 100 * (1 - np.sqrt(max(1 - value, 0.0))) if value <= 1 else 100.0
    if abs(percent) < 100 * least / 2:
        return "does not fall"
    return f"rises by {-percent:.2g} %" if percent < 0 else f"falls by {percent:.2g} % only"
