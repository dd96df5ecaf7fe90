"""What sensors and a drive make of a motion: rounding, delay, gain, noise, the owner's units."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.signal import butter, sosfilt, sosfreqz

from flexmodels.robot import Robot
from flexmodels.settings.processing import Column
from pyident.logs.log import Log, renamed


@dataclass(frozen=True)
class Sensors:
    """bits      of an encoder per turn, or per metre
    white, slow  noise of a torque over its rms; `slow` is low-passed at `corner` [Hz]
    gain         of the torques, against what the owner believes
    delay        of the encoders [s]
    constant     N m per A where currents are logged, else None
    """

    bits: int
    white: float
    slow: float
    corner: float
    gain: float = 1.0
    delay: float = 0.0
    constant: float | None = None


def drawn_sensors(rng: np.random.Generator, difficult: bool, period: float) -> Sensors:
    return Sensors(
        bits=int(rng.integers(16, 22)),
        white=rng.uniform(0.001, 0.006),
        slow=rng.uniform(0.0005, 0.004),
        corner=rng.uniform(1, 10),
        gain=1 + 0.02 * rng.choice([-1, 1]) if difficult else 1.0,
        delay=rng.uniform(0.5, 1.5) * period if difficult and rng.random() < 0.5 else 0.0,
        constant=rng.uniform(5, 20) if rng.random() < 0.5 else None,
    )


def noise_of(sensors: Sensors, level: np.ndarray) -> np.ndarray:
    """Standard deviation (n,) of the torques' noise, of torques with an rms (n,)."""
    return float(np.hypot(sensors.white, sensors.slow)) * level


def noise_power(sensors: Sensors, level: np.ndarray, count: int, period: float) -> np.ndarray:
    """(count // 2 + 1, n) at the frequencies of a log: variance of a torque's noise, on average its own."""
    f = np.fft.rfftfreq(count, period)
    gain = np.square(np.abs(sosfreqz(_low_pass(sensors, period), f, fs=1 / period)[1]))
    return np.square(level) * (sensors.white**2 + sensors.slow**2 * gain / gain.mean())[:, None]


def rounded(q: np.ndarray, sensors: Sensors, sliders: np.ndarray) -> np.ndarray:
    """Positions (..., n) in whole counts; `sliders` (n,)."""
    count = np.where(sliders, 1.0, 2 * np.pi) / 2**sensors.bits
    return count * np.round(q / count)


def recorded(
    time: np.ndarray,
    encoders: np.ndarray,
    tau: np.ndarray,
    level: np.ndarray,
    sensors: Sensors,
    rng: np.random.Generator,
) -> pd.DataFrame:
    """The file that the owner has: time, q1 .. [rad or m], i1 .. [A] or tau1 .. [N m].

    encoders, tau (N, n): what encoders read, and the true torques;  level (n,): rms of the torques
    """
    period = time[1] - time[0]
    low_pass = _low_pass(sensors, period)
    slow = np.asarray(sosfilt(low_pass, rng.standard_normal((len(time) + 2000, tau.shape[1])), axis=0))[2000:]
    slow /= slow.std(axis=0)
    noise = sensors.white * rng.standard_normal(tau.shape) + sensors.slow * slow
    logged = sensors.gain * tau + level * noise
    name, unit = ("i", sensors.constant) if sensors.constant else ("tau", 1.0)
    columns = {"time": time} | {f"q{k + 1}": q for k, q in enumerate(encoders.T)}
    return pd.DataFrame(columns | {f"{name}{k + 1}": t / unit for k, t in enumerate(logged.T)})


def _low_pass(sensors: Sensors, period: float) -> np.ndarray:
    return np.asarray(butter(2, min(2 * sensors.corner * period, 0.9), output="sos"))


def with_columns(robot: Robot, sensors: Sensors) -> Robot:
    """The file that knows what its owner's columns are called."""
    name, unit = ("i", sensors.constant) if sensors.constant else ("tau", 1.0)
    columns = {f"joint{k}.e": Column(f"q{k}") for k, _ in robot.numbered}
    columns |= {f"joint{k}.tau": Column(f"{name}{k}", unit) for k, _ in robot.numbered}
    return robot.with_settings(columns=columns)


def as_log(robot: Robot, frame: pd.DataFrame, source: str) -> Log:
    """The owner's file as the robot file reads it."""
    return Log.from_frame(renamed(frame, robot.settings.columns, source), source)
