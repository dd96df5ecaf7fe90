"""Sound logs, simulated and measured, of many robots: none of them may be called wrong."""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.signal import butter, lfilter, sosfiltfilt

from flexmodels.experiment import identification
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing
from pyident.logs.datasets import fetch
from pyident.logs.foreign import import_log, robot_log
from pyident.logs.log import Log, LogError
from pyident.logs.mapping import read_mapping
from pyident.simulation.fmu_runs import simulate_robot

from .swings import Motion, recorded, six_axes

Case = tuple[str, Robot, Log]


def good_logs() -> Iterator[Case]:
    """Name, robot and log of every case whose data are here."""
    for robot, log in measured():
        yield f"measured: {_short(log.source)}", robot, log
    for robot, log in foreign():
        yield f"another simulator: {_short(log.source)}", robot, log
    yield from _made()
    yield from _changed()
    yield from _own()


def unseen(draws: int = 20) -> Iterator[Case]:
    """Rigid arms of Pinocchio on motions drawn at random, which no threshold was fixed on."""
    for robot in (six_axes(), scara()):
        for i in range(draws if robot is not None else 0):
            assert robot is not None
            rng = np.random.default_rng([44, i])
            motion = drawn(rng)
            fit = _sampled(robot, motion)
            frame = recorded(fit, motion, 5000 + i, noise=float(10 ** rng.uniform(-6, -4.5)))
            if _within_limits(robot, frame):
                yield f"unseen: {robot.name}, {i}", fit, Log(frame, f"unseen{i}.csv")


def _within_limits(robot: Robot, frame: pd.DataFrame) -> bool:
    """Whether the arm could go so far; the sines are drawn without a look at its limits."""
    limits = {k: j.limits.position for k, j in robot.numbered if j.limits and j.limits.position}
    return all(np.ptp(frame[f"joint{k}.e"]) <= high - low for k, (low, high) in limits.items())


def drawn(rng: np.random.Generator) -> Motion:
    """A motion of any speed, length and rate that robots are recorded at; here and there an axis stands."""
    period = float(rng.choice([0.001, 0.002, 0.004, 0.005, 0.008, 0.01, 0.02]))
    return Motion(
        speed=float(10 ** rng.uniform(-1, 0.4)),
        highest=float(rng.uniform(0.2, 2.0)),
        duration=max(8.0, float(rng.uniform(1500, 5000)) * period),
        period=period,
        standing=tuple(int(k) for k in range(1, 5) if rng.random() < 0.15),
        rest=float(rng.choice([0.0, 0.0, 1.5])),
    )


def _sampled(robot: Robot, motion: Motion) -> Robot:
    """The robot with a controller and a filter for the motion's rate."""
    cutoff = min(robot.settings.processing.cutoff or 40.0, 0.2 / motion.period)
    controller = robot.controller and replace(robot.controller, rate=1 / motion.period)
    return replace(robot, controller=controller).with_settings(processing=Processing(cutoff=cutoff))


def data_folder() -> Path:
    return Path(os.environ.get("PYIDENT_DATA", "data"))


def scara() -> Robot | None:
    file = data_folder() / "foreign" / "null_scara" / "scara.toml"
    return load_robot(file) if file.is_file() else None


def foreign() -> Iterator[tuple[Robot, Log]]:
    """Logs of simulators that share no code with this project."""
    folder = data_folder() / "foreign"
    for file in sorted(folder.glob("*/*.parquet")):
        own = file.parent / "scara.toml"
        robot = load_robot(own if own.is_file() else "four_link")
        yield robot, robot_log(file, robot)


def measured() -> Iterator[tuple[Robot, Log]]:
    for name in ("emps", "tx40", "kuka_kr300"):
        robot = load_robot(name)
        try:
            files = fetch(name, download=False)
        except LogError:
            continue
        for group in [files] if name == "tx40" else [[file] for file in files]:
            yield robot, import_log(group, read_mapping(name), robot)
    yield from _so101()


def _so101() -> Iterator[tuple[Robot, Log]]:
    """A low-cost arm at 50 Hz; its torque is the magnitude of a current, so only positions are taken."""
    folder = data_folder() / "so101"
    if not folder.is_dir():
        return
    from flexmodels.files.urdf.importer import import_urdf

    robot = import_urdf(str(folder / "so101.urdf"), [], [])
    names = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll", "Jaw")
    for file in sorted(folder.glob("*.parquet")):
        raw = pd.read_parquet(file)
        time = 1e-6 * (raw["timestamp_us"] - raw["timestamp_us"].iloc[0]).to_numpy()
        even = np.arange(0, time[-1], 0.02006)
        frame = {"time": even}
        frame |= {
            f"joint{k}.e": np.interp(even, time, raw[f"position.{n}"]) for k, n in enumerate(names, start=1)
        }
        yield robot, Log(pd.DataFrame(frame), str(file))


def _made() -> Iterator[Case]:
    """Rigid arms of Pinocchio on motions of every kind."""
    motions = {
        "ordinary": Motion(),
        "slow": Motion(speed=0.08, highest=0.2, duration=30.0),
        "fast": Motion(speed=2.5, highest=2.0),
        "two axes at rest": Motion(standing=(2, 4)),
        "smooth start after 3 s of rest": Motion(rest=3.0, duration=15.0),
        "one axis after the other": Motion(in_turn=True, duration=24.0),
        "50 Hz": Motion(period=0.02, duration=30.0),
        "20 Hz, slow": Motion(period=0.05, speed=0.2, highest=0.3, duration=40.0),
        "1 kHz": Motion(period=0.001, duration=6.0),
        "four seconds": Motion(duration=4.0),
    }
    for robot in (six_axes(), scara()):
        for i, (name, motion) in enumerate(motions.items()):
            if robot is not None:
                fit = _sampled(robot, motion)
                yield f"{robot.name}, {name}", fit, Log(recorded(fit, motion, i), f"{name}.csv")


def _changed() -> Iterator[Case]:
    """What honest sensors and loggers do."""
    for robot, motion in ((six_axes(), Motion()), (scara(), Motion(speed=0.5))):
        if robot is None:
            continue
        frame = recorded(robot, motion, 50)
        for name, change in HONEST.items():
            yield f"{robot.name}, {name}", robot, Log(change(frame.copy()), f"{name}.csv")


def _quantised(frame: pd.DataFrame, step: float) -> pd.DataFrame:
    """A slide of less than 0.3 m has a scale of a tenth of the step."""
    steps = {n: step if np.ptp(frame[n]) > 0.3 else step / 10 for n in frame if n.endswith(".e")}
    return frame.assign(**{n: np.round(frame[n] / s) * s for n, s in steps.items()})


def _noisy(frame: pd.DataFrame, noise: float, torque: float) -> pd.DataFrame:
    rng = np.random.default_rng(9)
    size = {n: noise if n.endswith(".e") else torque * frame[n].std() for n in frame if n != "time"}
    return frame.assign(**{n: frame[n] + rng.normal(0, s, len(frame)) for n, s in size.items()})


def _zero_phase(frame: pd.DataFrame) -> pd.DataFrame:
    sections = np.asarray(butter(4, 10, fs=250, output="sos"))
    return frame.assign(**{n: sosfiltfilt(sections, frame[n]) for n in frame if n != "time"})


def _causal(frame: pd.DataFrame) -> pd.DataFrame:
    b, a = butter(2, 10, fs=250)  # pyright: ignore[reportAssignmentType, reportGeneralTypeIssues]
    names = [n for n in frame if n != "time"]
    filtered = {n: lfilter(b, a, frame[n] - frame[n].iloc[0]) + frame[n].iloc[0] for n in names}
    return frame.assign(**filtered)


HONEST: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "encoder of 20 bits": lambda f: _quantised(f, 2 * np.pi / 2**20),
    "encoder of 17 bits": lambda f: _quantised(f, 2 * np.pi / 2**17),
    "noise of 20 µrad and 2 %": lambda f: _noisy(f, 2e-5, 0.02),
    "noise of 100 µrad and 5 %": lambda f: _noisy(f, 1e-4, 0.05),
    "filtered without phase at 10 Hz": _zero_phase,
    "every channel through the same filter": _causal,
    "torques in 500 steps": lambda f: f.assign(
        **{
            n: np.round(f[n] / f[n].abs().max() * 250) * f[n].abs().max() / 250
            for n in f
            if n.endswith("tau")
        }
    ),
    "six decimals": lambda f: f.round(6),
    "cut in the middle of the motion": lambda f: f.iloc[777:2222].reset_index(drop=True),
    "another thousand seconds on the clock": lambda f: f.assign(time=f["time"] + 1000.0),
}


def _own() -> Iterator[Case]:
    """The project's own simulation, in closed loop, with and without references and feed-forward."""
    for name in ("four_link", "parallelogram"):
        robot = load_robot(name)
        frame = simulate_robot(robot, identification(robot, duration=10.0))
        yield f"{name}, own simulation", robot, Log(frame, "own.csv")
        bare = frame[[n for n in frame if not n.endswith((".r", ".tau_ff"))]]
        yield f"{name}, own simulation without tau_ff", robot, Log(_noisy(bare, 2e-6, 0.002), "bare.csv")  # pyright: ignore[reportArgumentType]


def _short(source: str) -> str:
    path = Path(source.split(", ")[0])
    return f"{path.parent.name}/{path.name}"
