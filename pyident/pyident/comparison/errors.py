"""Errors of a model on a log, each beside the signal and the floor that it is to be read against."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmodels.coordinate import is_motor, joint_name, joint_number


@dataclass(frozen=True)
class Error:
    """Root mean squares in `unit`: of what is missed, of the signal itself, of what the method leaves.

    floor   nan where the model cannot be simulated, and so is that over it
    Shares of a signal that is zero all the while, as of an equation that is never in use, are nan.
    """

    rmse: float
    signal: float
    floor: float
    unit: str

    @property
    def nrmse_percent(self) -> float:
        return 100 * self.rmse / self.signal if self.signal > 0 else float("nan")

    @property
    def floor_percent(self) -> float:
        return 100 * self.floor / self.signal if self.signal > 0 else float("nan")

    @property
    def ratio(self) -> float:
        return self.rmse / max(self.floor, 1e-300)

    def json(self) -> dict[str, Any]:
        return {
            "rmse": self.rmse,
            "unit": self.unit,
            "nrmse_percent": _known(self.nrmse_percent),
            "floor_percent": _known(self.floor_percent),
            "over_floor": _known(self.ratio),
        }


@dataclass(frozen=True)
class LogErrors:
    """Errors on one log. equations: coordinate -> Error;  simulation: signal -> Error, and `tip`.

    time, missed   (S,) [s] and signal -> (S,), log less simulation
    """

    log: str
    equations: dict[str, Error]
    simulation: dict[str, Error]
    time: np.ndarray
    missed: dict[str, np.ndarray]

    def json(self) -> dict[str, Any]:
        """The contract of `compare --json` for a log, and more."""
        motors = {n: joint_name(joint_number(n)) for n in (*self.equations, *self.simulation) if is_motor(n)}
        torque = {motors[n]: e.json() for n, e in self.equations.items() if n in motors}
        balances = {n: e.json() for n, e in self.equations.items() if n not in motors}
        e_rmse = {motors[n]: e.rmse for n, e in self.simulation.items() if n in motors}
        tip = {"tip_rmse_m": self.simulation["tip"].rmse} if "tip" in self.simulation else {}
        signals = {name: e.json() for name, e in self.simulation.items()}
        return {
            "torque": torque,
            "deformation_balance": balances,
            "simulation": tip | {"e_rmse": e_rmse, "signals": signals},
        }


def _known(value: float) -> float | None:
    return None if np.isnan(value) else value
