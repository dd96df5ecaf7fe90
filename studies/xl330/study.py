"""XL330: a servo without torque sensor, its friction found from positions, one gain held out at a time."""

import os
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.robot import Robot, RobotError
from pyident.logs.foreign import robot_log
from pyident.logs.mapping import read_mapping
from pyident.refinement.closed_loop import ClosedLoopFit, ServoLog, fit_closed_loop, replay_errors
from pyident.report.page import Picture, Section, write_page
from pyident.rules.confidence import CONFIDENCE
from pyident.simulation.fmu_runs import batches_here
from pyident.sweep.studies import StudyResult, row

from .figure import draw
from .ladder import RUNGS, STEP, Ladder, Track, compiled

_HERE = Path(__file__).parent
_INERTIA, _WEIGHT = 0.0049, 0.49 * 9.80665 * 0.1
_LAWS = ("load_dependent_friction", "quadratic_load_friction", "stribeck")
_WORTH = 0.9  # of the error at a gain that was not fitted: what a further law must come below
_CLIMB_ROUNDS = 8
_SUMMARY = (
    "A servo without torque sensor lifts a pendulum. Its friction, drive and delay follow from commands and "
    "positions, in closed loop. Each gain is held out once: neither laws nor values know it then."
)
_CAPTION = (
    "Above: errors at a gain that was held out, beside the ladder of friction laws M1 to M6 refitted to the "
    "same logs. Below: the written model, fitted to all gains, under the commands of every log."
)
_POSE = ("link1.ms[x]",)  # the zero of the encoder is not quite straight down

Recordings = Mapping[str, ServoLog]


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Fit, judge, write model.toml and mapping.toml. Without the data the table says so."""
    data = Path(os.environ.get("PYIDENT_DATA", "data")) / "bam_xl330"
    files = sorted(data.glob("*_kp*.csv"))
    if not files:
        return StudyResult([], notes=[f"skipped: {data} holds no logs; set PYIDENT_DATA to the data sets"])
    start = load_robot(_HERE / "start.toml")
    mapping = read_mapping(_HERE / "mapping.toml")
    recordings = {
        file.stem: ServoLog(robot_log(file, start, mapping), {"servo.kp": float(_gain(file.stem))})
        for file in files
    }
    robot, steps = climbed(start, recordings, lambda share: progress(0.3 * share))
    gains, rows, bars = _gains(recordings), [], []
    with compiled(_INERTIA, _WEIGHT) as ladder:
        for i, gain in enumerate(gains):
            ours, laws = held_out(start, recordings, gain)
            theirs = {rung: _ladder_error(ladder, rung, recordings, gain, start) for rung in RUNGS}
            best = min(theirs, key=lambda rung: theirs[rung])
            text = f"{ours:.2f}° ({laws}) against {theirs[best]:.2f}° of {best}, the ladder's best"
            rows.append(row(f"kp {gain} held out: mean absolute error", text, "less", ours < theirs[best]))
            bars.append((gain, ours, theirs))
            progress(0.3 + 0.6 * (i + 1) / len(gains))
    fit = _fitted(robot, list(recordings.values()))
    rows += _described(fit, recordings, robot)
    save_robot(fit.robot, folder / "model.toml")
    shutil.copy(_HERE / "mapping.toml", folder / "mapping.toml")
    with batches_here(fit.robot) as runs:
        replays = replay_errors(fit.robot, list(recordings.values()), runs)
    picture = Picture(draw(bars, list(recordings.items()), replays), _CAPTION)
    sections = [
        Section("Every log", pictures=[picture]),
        Section("Numbers", table=pd.DataFrame(rows)),
        Section("How the laws were chosen", table=pd.DataFrame({"step": steps})),
    ]
    page = write_page(folder / "index.html", "XL330", _SUMMARY, sections)
    progress(1.0)
    return StudyResult(rows, [page], steps)


def climbed(
    robot: Robot, recordings: Recordings, progress: Callable[[float], None]
) -> tuple[Robot, list[str]]:
    """From Coulomb and viscous friction up: the law that helps most at a gain that is not fitted.

    That gain is the middle one of three, the lower one of two. What was tried is told, a sentence a step.
    """
    gains = _gains(recordings)
    gain = gains[(len(gains) - 1) // 2]
    robot, error = _judged(robot, recordings, gain)
    told = [f"Coulomb and viscous friction: {error:.2f}° at kp {gain}, fitted at the other gains"]
    for number in range(len(_LAWS)):
        tried = {
            law: _judged(robot.with_effect(1, law), recordings, gain)
            for law in _LAWS
            if law not in robot.joints[0].values and _allowed(robot, law)
        }
        progress((number + 1) / len(_LAWS))
        if not tried:
            break
        best = min(tried, key=lambda law: tried[law][1])
        taken = tried[best][1] < _WORTH * error
        errors = ", ".join(f"{law} {value:.2f}°" for law, (_, value) in tried.items())
        told.append(f"with {errors}: " + (f"{best} is taken" if taken else "none helps by a tenth"))
        if not taken:
            break
        robot, error = tried[best]
    return robot, told


def held_out(start: Robot, recordings: Recordings, gain: int) -> tuple[float, str]:
    """Mean absolute error [degrees] at a gain that neither the laws nor their values were chosen by."""
    others, (robot, _) = _without(recordings, gain), climbed(start, _without(recordings, gain), _silent)
    laws = [law for law in _LAWS if law in robot.joints[0].values]
    return _error(_fitted(robot, list(others.values())).robot, _only(recordings, gain)), ", ".join(laws)


def _judged(robot: Robot, recordings: Recordings, gain: int) -> tuple[Robot, float]:
    """The robot fitted without a gain, and its mean absolute error there [degrees]."""
    fit = _fitted(robot, list(_without(recordings, gain).values()), _CLIMB_ROUNDS)
    return fit.robot, _error(fit.robot, _only(recordings, gain))


def _allowed(robot: Robot, law: str) -> bool:
    try:
        effect = robot.with_effect(1, law).joints[0].law(law)
    except RobotError:
        return False
    return not effect.excess_over or effect.excess_over in robot.joints[0].values


def _fitted(robot: Robot, recordings: Sequence[ServoLog], rounds: int = 20) -> ClosedLoopFit:
    assert robot.servo is not None
    free = [*robot.servo.free, *(name for name in robot.parameters if name.startswith("joint1.")), *_POSE]
    with batches_here(robot) as runs:
        return fit_closed_loop(robot, recordings, free, runs, rounds)


def _error(robot: Robot, recordings: Sequence[ServoLog]) -> float:
    with batches_here(robot) as runs:
        errors = [np.abs(e).mean() for _, e in replay_errors(robot, recordings, runs)]
    return float(np.degrees(np.mean(errors)))


def _ladder_error(ladder: Ladder, rung: str, recordings: Recordings, gain: int, robot: Robot) -> float:
    tracks = {name: _track(recording, robot) for name, recording in recordings.items()}
    values = ladder.fit(rung, [track for name, track in tracks.items() if _gain(name) != gain])
    return float(np.degrees(ladder.error(values, [t for name, t in tracks.items() if _gain(name) == gain])))


def _track(recording: ServoLog, robot: Robot) -> Track:
    assert robot.servo is not None
    frame = recording.log.frame
    time = frame["time"].to_numpy()
    steps = np.arange(time[0], time[-1], STEP)
    at = {name: np.interp(steps, time, frame[f"joint1.{name}"]) for name in ("r", "e", "on")}
    gain = robot.servo.gain[0] * recording.settings["servo.kp"]
    return Track(gain, robot.servo.supply, at["r"], at["e"], (at["on"] > 0.5).astype(float))


def _described(fit: ClosedLoopFit, recordings: Recordings, robot: Robot) -> list[dict[str, str]]:
    units = robot.units | {"joint1.servo.kt": "N.m/A", "joint1.servo.R": "Ohm", "servo.delay": "s"}
    rows = [row("all gains fitted: mean absolute error", f"{np.degrees(np.mean(fit.error)):.2f}°")]
    for name, value in fit.values.items():
        spread = f" ± {CONFIDENCE * fit.std[name]:.2g}" if fit.std else ""
        rows.append(row(name, f"{value:.4g}{spread} {units[name]} (95 %, jackknife over logs)"))
    return rows


def _gains(recordings: Recordings) -> list[int]:
    return sorted({_gain(name) for name in recordings})


def _without(recordings: Recordings, gain: int) -> Recordings:
    return {name: r for name, r in recordings.items() if _gain(name) != gain}


def _only(recordings: Recordings, gain: int) -> list[ServoLog]:
    return [r for name, r in recordings.items() if _gain(name) == gain]


def _silent(_: float) -> None:
    """Progress of a part."""


def _gain(name: str) -> int:
    match = re.search(r"_kp(\d+)$", name)
    assert match is not None
    return int(match[1])
