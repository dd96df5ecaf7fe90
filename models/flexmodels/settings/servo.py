"""A servo: what turns a commanded position into torque where nobody logs the torque.

A digital position loop sets the duty of the voltage on a DC motor:

    error  = r(t - delay) - e, zero within the dead band
    duty   = gain (kp error + ki ∫ error dt - kd de), held within ± limit
    current = (supply duty - kt de) / R
    torque = kt current / (1 + saturation |current|), held until the next sample; zero while the servo is off

kt and R are those seen at the joint: of the motor, times the gear's ratio and its square. Iron that
saturates loses torque by Froelich's curve (Fitzgerald, Kingsley and Umans, Electric Machinery).
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from flexmodels.coordinate import joint_number, of_joint

PER_JOINT: dict[str, tuple[str, str]] = {
    "kp": ("1", "Proportional gain in the servo's own units"),
    "ki": ("1/s", "Integral gain in the servo's own units"),
    "kd": ("s", "Gain on the measured speed in the servo's own units"),
    "gain": ("1/rad", "Duty per rad of error and unit of kp"),
    "limit": ("1", "Largest duty"),
    "dead_band": ("rad", "Error that the servo takes for none"),
    "kt": ("N.m/A", "Torque per current at the joint, and voltage per speed"),
    "R": ("Ohm", "Resistance of the motor"),
    "saturation": ("1/A", "Inverse of the current at which half of the torque is lost to saturation"),
}
SHARED: dict[str, tuple[str, str]] = {
    "supply": ("V", "Voltage of the supply"),
    "delay": ("s", "From a command to its effect"),
}
POSITIVE = frozenset({"R"})
LONGEST_DELAY = 250  # samples of the loop, see runtime/servo.h


@dataclass(frozen=True)
class Servo:
    """Per joint in SI units (see PER_JOINT, SHARED); rate [Hz] of the position loop.

    unknown   names such as "kt" or "delay" that identification may change
    """

    rate: float
    supply: float
    kp: tuple[float, ...]
    gain: tuple[float, ...]
    kt: tuple[float, ...]
    R: tuple[float, ...]
    ki: tuple[float, ...]
    kd: tuple[float, ...]
    limit: tuple[float, ...]
    dead_band: tuple[float, ...]
    saturation: tuple[float, ...]
    delay: float = 0.0
    unknown: tuple[str, ...] = ()

    @property
    def period(self) -> float:
        return 1.0 / self.rate

    @property
    def parameters(self) -> dict[str, float]:
        """`servo.delay` of all joints, `joint{k}.servo.kp` of one."""
        joints = {
            of_joint(k, f"servo.{name}"): value
            for name in PER_JOINT
            for k, value in enumerate(getattr(self, name), start=1)
        }
        return joints | {f"servo.{name}": getattr(self, name) for name in SHARED}

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the parameters that are unknown."""
        wanted = set(self.unknown)
        return tuple(name for name in self.parameters if name.rpartition(".")[2] in wanted)

    def with_parameters(self, values: Mapping[str, float]) -> "Servo":
        """Other values by name; `servo.kp` stands for every joint's."""
        new = {field.name: getattr(self, field.name) for field in fields(self)}
        for name, value in values.items():
            place, _, key = name.rpartition(".")
            if key in SHARED:
                new[key] = float(value)
            elif place == "servo":
                new[key] = (float(value),) * len(self.kp)
            else:
                k = joint_number(place)
                new[key] = tuple(float(value) if i == k else v for i, v in enumerate(new[key], start=1))
        return replace(self, **new)

    def torque(
        self, reference: np.ndarray, e: np.ndarray, de: np.ndarray, on: np.ndarray, time: np.ndarray
    ) -> np.ndarray:
        """Torques (N, joints) of a recorded motion: the same law without its sampling, for N samples.

        reference, e, de   (N, joints);  on   (N, joints), 0 where the servo is off;  time (N,) [s]
        """
        late = np.column_stack([np.interp(time - self.delay, time, r) for r in reference.T])
        error = late - e
        error = np.where(np.abs(error) < self.dead_band, 0.0, error)
        step = np.diff(time, prepend=time[0])[:, None]
        drive = np.array(self.kp) * error + np.array(self.ki) * np.cumsum(error * step, axis=0)
        duty = np.clip(
            np.array(self.gain) * (drive - np.array(self.kd) * de), -np.array(self.limit), self.limit
        )
        kt = np.array(self.kt)
        current = (self.supply * duty - kt * de) / np.array(self.R)
        return kt * current / (1 + np.array(self.saturation) * np.abs(current)) * (on > 0.5)
