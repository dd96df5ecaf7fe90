"""SO-101: a whole low-cost arm from commands and encoders alone, judged on motions that were not fitted."""

import os
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.named_values import with_settings
from flexmodels.robot import Robot
from pyident.logs.foreign import robot_log
from pyident.logs.mapping import read_mapping
from pyident.refinement.closed_loop import ClosedLoopFit, ServoLog, fit_closed_loop, replay_errors
from pyident.report.page import Picture, Section, write_page
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.fmu_runs import runs_here
from pyident.simulation.simulator import Simulate
from pyident.sweep.studies import StudyResult, row

from .figure import draw

_HERE = Path(__file__).parent
FITTED = ("friction_gravity", "multisine", "prbs_excitation", "step_response")
CHOOSING = ("single_joint_elbow", "slow_precision")  # decide between structures, and are not judged
_SECONDS = 40.0  # of each fitted motion
_ROUNDS, _MORE = 6, 4  # of the first fit, and of those that start from another one
_KINDS = ("servo.kt", "coulomb", "viscous", "offset")
_LOAD, _BAND = "load_dependent_friction.coefficient", "servo.dead_band"
_WORTH = 0.97  # of the error on the choosing motions: what a further law must come below
_SUMMARY = (
    "A low-cost arm of six servos, from commands and encoders alone: four motions are fitted, two choose "
    "between structures, and six are left to judge."
)
_CAPTION = (
    "Above: what the model leaves of each motion's tracking error. Below: the elbow over half a minute."
)
_ENCODER_STEP = 1.53e-3  # [rad]
_STEP = 0.002  # [s] of the solver while fitting
_GOAL = 0.5  # of the tracking error

Recordings = Mapping[str, ServoLog]


@dataclass(frozen=True)
class Structure:
    """A fit of some kinds of parameters at every joint; error: rms on the choosing motions [rad]."""

    name: str
    kinds: tuple[str, ...]
    fit: ClosedLoopFit
    error: float


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Fit, judge, write model.toml and mapping.toml. Without the data the table says so."""
    data = Path(os.environ.get("PYIDENT_DATA", "data")) / "so101"
    files = sorted(data.glob("*.parquet"))
    if not files:
        return StudyResult([], notes=[f"skipped: {data} holds no logs; set PYIDENT_DATA to the data sets"])
    start, mapping = load_robot(_HERE / "start.toml"), read_mapping(_HERE / "mapping.toml")
    recordings = {file.stem: ServoLog(robot_log(file, start, mapping), {}) for file in files}
    structures, told = chosen(start, recordings, lambda share: progress(0.6 * share))
    best = structures[-1]
    with runs_here(best.fit.robot) as simulate:
        errors = replayed(best.fit.robot, recordings, _coarse(simulate))
        progress(0.8)
        whole = fitted(best.fit.robot, recordings, best.kinds, tuple(recordings), simulate)
    rows = [*judged(recordings, errors), *named(structures), _of_the_written_model(whole)]
    save_robot(whole.robot, folder / "model.toml")
    shutil.copy(_HERE / "mapping.toml", folder / "mapping.toml")
    picture = Picture(draw(recordings, errors, FITTED), _CAPTION)
    sections = [
        Section("Every motion", pictures=[picture]),
        Section("Numbers", table=pd.DataFrame(rows)),
        Section("How the structure was chosen", table=pd.DataFrame({"step": told})),
    ]
    page = write_page(folder / "index.html", "SO-101", _SUMMARY, sections)
    progress(1.0)
    return StudyResult(rows, [page], told)


def chosen(
    start: Robot, recordings: Recordings, progress: Callable[[float], None]
) -> tuple[list[Structure], list[str]]:
    """Every structure that was tried, the chosen one last; what was tried, a sentence each."""
    plain = _structure("Coulomb, viscous, offset, delay", start, recordings, _KINDS, _ROUNDS)
    progress(1 / 3)
    tried, best = [plain], plain
    told = [f"{plain.name}: {np.degrees(plain.error):.3f}° on {' and '.join(CHOOSING)}"]
    for name, kind in (("load friction", _LOAD), ("dead band", _BAND)):
        robot = best.fit.robot
        if kind == _LOAD:
            robot = _with_load_friction(robot)
        else:  # from zero it would not leave zero: below the encoder's step it changes nothing
            robot = with_settings(robot, {"servo.dead_band": _ENCODER_STEP})
        further = _structure(name, robot, recordings, (*best.kinds, kind))
        taken = further.error < _WORTH * best.error
        told.append(f"with {name}: {np.degrees(further.error):.3f}°, {'taken' if taken else 'not taken'}")
        tried.append(further)
        best = further if taken else best
        progress(len(tried) / 3)
    return [*(s for s in tried if s is not best), best], told


def fitted(
    robot: Robot,
    recordings: Recordings,
    kinds: Sequence[str],
    names: Sequence[str],
    simulate: Simulate,
    rounds: int = _MORE,
) -> ClosedLoopFit:
    """The kinds of parameters at every joint, and the delay, from the beginnings of some motions."""
    groups = [[f"joint{k}.{kind}" for k, _ in robot.numbered] for kind in kinds] + [["servo.delay"]]
    free = [name for group in groups for name in group]
    parts = [_beginning(recordings[name]) for name in names]
    return fit_closed_loop(robot, parts, free, _coarse(simulate), rounds, groups)


def _coarse(simulate: Simulate) -> Simulate:
    """With longer steps of the solver: the servos sample every 4 ms."""

    def run(plan: Experiment, sets: Sequence[Mapping[str, float]]) -> Iterable[pd.DataFrame]:
        return simulate(plan, [{**one, "solver.step": _STEP} for one in sets])

    return run


def replayed(
    robot: Robot, recordings: Recordings, simulate: Simulate
) -> dict[str, tuple[pd.DataFrame, float]]:
    """Per motion its simulation, and simulated − measured position, rms over all joints [rad]."""
    replays = replay_errors(robot, list(recordings.values()), simulate)
    return {n: (frame, _rms(error)) for n, (frame, error) in zip(recordings, replays, strict=True)}


def tracking(recording: ServoLog) -> float:
    """Measured − commanded position, rms over all joints [rad]."""
    frame = recording.log.frame
    joints = range(1, sum(name.endswith(".r") for name in frame) + 1)
    return _rms(np.column_stack([frame[f"joint{k}.e"] - frame[f"joint{k}.r"] for k in joints]))


def judged(recordings: Recordings, errors: Mapping[str, tuple[pd.DataFrame, float]]) -> list[dict[str, str]]:
    """A row per motion; those that were neither fitted nor chosen by are held to the goal."""
    rows = []
    for name, (_, error) in errors.items():
        whole = tracking(recordings[name])
        text = f"{np.degrees(error):.2f}° of {np.degrees(whole):.2f}° tracking error ({error / whole:.2f})"
        use = "fitted" if name in FITTED else "chosen by" if name in CHOOSING else ""
        if use:
            rows.append(row(f"{name} ({use}): simulated − measured", text))
        else:
            rows.append(row(f"{name}: simulated − measured", text, f"{_GOAL:g}", error <= _GOAL * whole))
    return rows


def named(structures: Sequence[Structure]) -> list[dict[str, str]]:
    """Delay, load friction, dead band and what can be said of backlash, with intervals."""
    last = structures[-1].fit
    rows = [row("delay of the commands", f"{_interval(last, 'servo.delay', 1e3)} ms")]
    for kind, what, scale, unit in ((_LOAD, "load friction", 1.0, ""), (_BAND, "dead band", 1e3, " mrad")):
        one = next((s.fit for s in reversed(structures) if kind in s.kinds), None)
        for k in range(1, 7) if one else ():
            assert one is not None
            name = f"joint{k}.{kind}"
            assert one.std is not None
            sure = one.values[name] > CONFIDENCE * one.std[name]
            verdict = "named" if sure else "not told from none"
            rows.append(row(f"joint {k}: {what}", f"{_interval(one, name, scale)}{unit}: {verdict}"))
    text = "none to be seen: the encoder sits behind the gear, a gap acts as the dead band above"
    return [*rows, row("backlash", text)]


def _of_the_written_model(fit: ClosedLoopFit) -> dict[str, str]:
    text = f"{np.degrees(np.mean(fit.error)):.3f}° over their first {_SECONDS:g} s"
    return row("model.toml, fitted to all motions: mean absolute error", text)


def _structure(
    name: str, robot: Robot, recordings: Recordings, kinds: tuple[str, ...], rounds: int = _MORE
) -> Structure:
    with runs_here(robot) as simulate:
        fit = fitted(robot, recordings, kinds, FITTED, simulate, rounds)
        errors = replayed(fit.robot, {name: recordings[name] for name in CHOOSING}, _coarse(simulate))
    return Structure(name, kinds, fit, float(np.mean([error for _, error in errors.values()])))


def _beginning(recording: ServoLog) -> ServoLog:
    frame = recording.log.frame
    frame = frame[frame["time"] < frame["time"].iloc[0] + _SECONDS].reset_index(drop=True)
    return replace(recording, log=replace(recording.log, frame=frame))


def _with_load_friction(robot: Robot) -> Robot:
    for k, _ in robot.numbered:
        robot = robot.with_effect(k, "load_dependent_friction")
    return robot


def _interval(fit: ClosedLoopFit, name: str, scale: float) -> str:
    assert fit.std is not None
    half = CONFIDENCE * scale * fit.std[name]
    if not np.isfinite(half):
        return f"{scale * fit.values[name]:.3g}, on its bound"
    return f"{scale * fit.values[name]:.3g} ± {half:.2g} (95 %, jackknife over logs)"


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
