"""Other people's recordings -> Log: columns found, joined, mapped, on one clock, referred to the joints."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline

from flexmodels.coordinate import deformation_of, motor_of, of_joint, torque_of
from flexmodels.robot import Robot
from pyident.logs.clocks import on_one_clock
from pyident.logs.disk import LogFile, open_log
from pyident.logs.formats.read import read_recording
from pyident.logs.formats.recording import Recording
from pyident.logs.log import Log, LogError, read_log
from pyident.logs.mapping import Mapping
from pyident.logs.steps import evened, filled

_AGAINST = 0.1  # of what they do apart: encoders that turn together, one with the wrong sign


def import_log(files: Sequence[str | Path], mapping: Mapping, robot: Robot | None = None) -> Log:
    """Files of one recording, side by side, as a log under our names; what was done to it is in `notes`.

    With a robot, motor-side columns are referred to its joints and link encoders become eps[1].
    Raises LogError.
    """
    source = ", ".join(str(file) for file in files)
    read = [(Path(f), read_recording(Path(f), mapping.header, mapping.episode)) for f in files]
    log = map_columns(_joined(read), mapping, source, robot)
    said = [f"{path}: {note}" for path, recording in read for note in recording.notes]
    return replace(log, notes=(*said, *log.notes))


def map_frame(frame: pd.DataFrame, mapping: Mapping, source: str, robot: Robot | None = None) -> Log:
    """The same from the columns of a data frame. Raises LogError."""
    return map_columns({str(n): c.to_numpy() for n, c in frame.items()}, mapping, source, robot)


def map_columns(raw: dict[str, np.ndarray], mapping: Mapping, source: str, robot: Robot | None) -> Log:
    """Columns (N,) of a foreign recording as a log in SI units on one clock, of even steps.

    robot   refers the motors' signals to the joints; None leaves them. Raises LogError.
    """
    frame, notes = on_one_clock(raw, mapping, source)
    if mapping.asked:
        many = "a question" if len(mapping.asked) == 1 else f"{len(mapping.asked)} questions"
        open_ones = f"the mapping still asks {many} (lines that begin with # ?)"
        notes = [f"{open_ones}: what they are about is guessed; correct it and delete them", *notes]
    frame, lacked = filled(frame)
    frame, resampled = evened(frame, source)
    notes += lacked + resampled
    delays = {name: s.delay for name, s in mapping.signals.items() if s.delay}
    frame = delayed(frame, delays)
    notes += [f"{name} was moved by {1e3 * d:g} ms" for name, d in delays.items()]
    if robot is not None:
        frame = at_joints(frame, robot, source)
    return Log(frame, source, tuple(notes))


def robot_log(path: str | Path, robot: Robot, mapping: Mapping | None = None) -> Log:
    """A log of `robot`: through a mapping file, or by the robot's own [columns]. Raises LogError."""
    if mapping is not None:
        return import_log([path], mapping, robot)
    return _at_its_joints(read_log(path, robot.settings.columns), robot)


def open_robot_log(path: str | Path, robot: Robot, mapping: Mapping | None = None) -> Log | LogFile:
    """The same, but a long log that needs neither mapping nor transmission stays on disk. Raises LogError."""
    log = robot_log(path, robot, mapping) if mapping else open_log(path, robot.settings.columns)
    if isinstance(log, Log):
        return log if mapping else _at_its_joints(log, robot)
    foreign = any(name.startswith("motor") or name.endswith(".link") for name in log.names)
    return robot_log(path, robot) if foreign else log


def delayed(frame: pd.DataFrame, delays: dict[str, float]) -> pd.DataFrame:
    """Columns that were sampled `delay` [s] before their time stamp, at their time stamps (cubic splines)."""
    time = frame["time"].to_numpy(float)
    if len(time) < 4 or not (np.diff(time) > 0).all() or not np.isfinite(frame.to_numpy(float)).all():
        return frame  # the check that follows explains it
    moved = {name: sooner(time, frame[name].to_numpy(float), delay) for name, delay in delays.items()}
    return frame.assign(**moved)


def sooner(time: np.ndarray, values: np.ndarray, delay: float) -> np.ndarray:
    """(N,) values at times (N,) [s] which they were read a delay [s] after, as at both ends beyond these."""
    return CubicSpline(time, values)(np.clip(time + delay, time[0], time[-1]))


def _at_its_joints(log: Log, robot: Robot) -> Log:
    return Log(at_joints(log.frame, robot, log.source), log.source, log.notes)


def at_joints(frame: pd.DataFrame, robot: Robot, source: str) -> pd.DataFrame:
    """Motor angles, torques or currents through the robot's transmission; link encoders as twists.

    Raises LogError.
    """
    n = len(robot.joints)
    out = frame.copy()
    motors = [name for name in frame if str(name).startswith("motor")]
    gear = robot.transmission
    if motors and gear is None:
        raise LogError(f"{source}: column {motors[0]} is on the motor side; give the robot a [transmission]")
    if gear is not None and motors:
        if (angles := _all(frame, "q", n, source)) is not None:
            out[[motor_of(k + 1) for k in range(n)]] = gear.angles(angles)
        torques = _all(frame, "tau", n, source)
        if torques is None and (currents := _all(frame, "current", n, source)) is not None:
            if gear.drive is None:
                raise LogError(f"{source}: currents need transmission.drive, the motors' torque per ampere")
            torques = currents * np.array(gear.drive)
        if torques is not None:
            out[[torque_of(k + 1) for k in range(n)]] = gear.torques(torques)
    for k in range(1, n + 1):
        if of_joint(k, "link") in out:
            out[deformation_of(k)] = _twist(k, out, source)
    links = [of_joint(k, "link") for k in range(1, n + 1)]
    return out.drop(columns=[*motors, *(name for name in links if name in out)])


def _twist(k: int, frame: pd.DataFrame, source: str) -> np.ndarray:
    """(N,) of the drive of joint k (from 1) by its two encoders. Raises LogError."""
    motor, link = (frame[name].to_numpy(float) for name in (motor_of(k), of_joint(k, "link")))
    if np.std(link + motor) < _AGAINST * np.std(link - motor):
        raise LogError(
            f"{source}: the link of joint {k} turns against its motor, as far as that does; give one of them "
            "the other sign in the mapping (`sign = -1`, or a negative `gear`)"
        )
    return link - motor


def _all(frame: pd.DataFrame, signal: str, n: int, source: str) -> np.ndarray | None:
    names = [f"motor{k}.{signal}" for k in range(1, n + 1)]
    there = [name for name in names if name in frame]
    if not there:
        return None
    if len(there) < n:
        lacking = next(name for name in names if name not in frame)
        raise LogError(f"{source}: column {lacking} is missing; the transmission needs all {n} motors")
    return frame[names].to_numpy(float)


def _joined(files: list[tuple[Path, Recording]]) -> dict[str, np.ndarray]:
    """Columns under their names, and under `file:name`."""
    raw: dict[str, np.ndarray] = {}
    for path, recording in files:
        for name, values in recording.columns.items():
            raw.setdefault(name, values)
            raw[f"{path.stem}:{name}"] = values
    return raw
