"""The loop that drives the joints."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Controller:
    """Digital PID with held torque, sampled at `rate` [Hz]; gains per joint, SI."""

    rate: float
    Kp: tuple[float, ...]
    Kd: tuple[float, ...]
    Ki: tuple[float, ...]

    @property
    def period(self) -> float:
        return 1.0 / self.rate
