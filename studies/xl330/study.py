"""XL330: a servo without torque sensor, its friction found from positions, one gain held out at a time."""

import os
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.link import Link
from flexmodels.robot import Robot
from flexmodels.settings.servo import PER_JOINT
from pyident.logs.foreign import robot_log
from pyident.logs.mapping import read_mapping
from pyident.refinement.closed_loop import ClosedLoopFit, ServoLog
from pyident.report.page import Picture, Section, write_page
from pyident.rules.confidence import CONFIDENCE
from pyident.sweep.studies import StudyResult, row

from .climb import Climbed, Fits, Recordings, climbed
from .climb import fits as opened
from .figure import draw
from .ladder import RUNGS, STEP, Ladder, Track, compiled

_HERE = Path(__file__).parent
_INERTIA, _WEIGHT = 0.0049, 0.49 * 9.80665 * 0.1
_SUMMARY = (
    "A servo without torque sensor lifts a pendulum. Its friction, drive and delay follow from commands and "
    "positions, in closed loop. Each gain is held out once: neither laws nor values know it then."
)
_CAPTION = (
    "Above: errors at a gain that was held out, beside the ladder of friction laws M1 to M6 refitted to the "
    "same logs. Below: the written model, fitted to all gains, under the commands of every log."
)


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
    gains, rows, bars = _gains(recordings), [], []
    choices: dict[str, Sequence[str]] = {}
    with compiled(_INERTIA, _WEIGHT) as ladder, opened() as fits:
        chosen = climbed(start, recordings, fits, lambda share: progress(0.25 * share))
        choices["all recordings"] = chosen.told
        fit = fits.fit(chosen.robot, list(recordings.values()))
        replays = fits.replays(fit.robot, list(recordings.values()))
        for i, gain in enumerate(gains):

            def told(share: float, i: int = i) -> None:
                progress(0.3 + 0.65 * (i + 0.8 * share) / len(gains))

            ours, climb = held_out(start, recordings, gain, fits, told)
            choices[f"all but kp {gain}"] = climb.told
            theirs = {rung: _ladder_error(ladder, rung, recordings, gain, start) for rung in RUNGS}
            best = min(theirs, key=lambda rung: theirs[rung])
            text = f"{ours:.2f}° ({climb.laws}) against {theirs[best]:.2f}° of {best}, the ladder's best"
            rows.append(row(f"kp {gain} held out: mean absolute error", text, "less", ours < theirs[best]))
            bars.append((gain, ours, theirs))
    rows += _described(fit)
    save_robot(as_a_body(fit.robot, start), folder / "model.toml")
    shutil.copy(_HERE / "mapping.toml", folder / "mapping.toml")
    picture = Picture(draw(bars, list(recordings.items()), replays), _CAPTION)
    sections = [
        Section("Every log", pictures=[picture]),
        Section("Numbers", table=pd.DataFrame(rows)),
        Section("How the laws were chosen", table=_steps(choices)),
    ]
    page = write_page(folder / "index.html", "XL330", _SUMMARY, sections)
    progress(1.0)
    return StudyResult(rows, [page], list(chosen.told))


def held_out(
    start: Robot, recordings: Recordings, gain: int, fits: Fits, progress: Callable[[float], None]
) -> tuple[float, Climbed]:
    """Mean absolute error [degrees] at a gain that neither the laws nor their values were chosen by."""
    others = _without(recordings, gain)
    chosen = climbed(start, others, fits, progress)
    robot = fits.fit(chosen.robot, list(others.values())).robot
    return fits.error(robot, _only(recordings, gain)), chosen


def _steps(choices: Mapping[str, Sequence[str]]) -> pd.DataFrame:
    return pd.DataFrame([{"chosen by": by, "step": step} for by, steps in choices.items() for step in steps])


def as_a_body(robot: Robot, start: Robot) -> Robot:
    """The pendulum's inertia about its centre of mass, which the fit has moved, as it was before.

    Without that no rigid body has its moments, and no other simulator takes them. Only the sum of its and the
    motor's inertia about the hinge moves it: J_m keeps the sum.
    """
    (link,), (before,), axis = robot.links, start.links, np.array(robot.joints[0].x)
    body = Link.of_centre(link.m, np.array(link.ms) / link.m, before.about_centre()[1])
    about = [axis @ _tensor(one) @ axis for one in (link, body)]
    J_m = robot.parameters["joint1.J_m"] + about[0] - about[1]
    return replace(robot, links=(body,)).with_parameters({"joint1.J_m": float(J_m)})


def _tensor(link: Link) -> np.ndarray:
    xx, xy, xz, yy, yz, zz = link.J
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


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


def _described(fit: ClosedLoopFit) -> list[dict[str, str]]:
    servo = {f"joint1.servo.{name}": unit for name, (unit, _) in PER_JOINT.items()}
    units = fit.robot.units | servo | {"servo.delay": "s"}
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


def _gain(name: str) -> int:
    match = re.search(r"_kp(\d+)$", name)
    assert match is not None
    return int(match[1])
