"""What a run of a parameter study is reduced to: functions of its log and of the reference run's.

A metric takes two frames with the columns of a log and returns a number, or numbers by name. These become the
columns `metric` or `metric.name` of the study's table.
"""

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd

from flexmodels.coordinate import is_deformation, is_torque, joint_name, joint_number

Metric = Callable[[pd.DataFrame, pd.DataFrame], float | Mapping[str, float]]
_TIP = ["tip.x", "tip.y", "tip.z"]


def tip_error(log: pd.DataFrame, reference: pd.DataFrame) -> dict[str, float]:
    """Distance of the tip from the reference run's at the same time [m]: largest and rms."""
    distance = np.linalg.norm(log[_TIP].to_numpy() - reference[_TIP].to_numpy(), axis=1)
    return {"max": float(distance.max()), "rms": float(np.sqrt(np.mean(distance**2)))}


def torque_rms(log: pd.DataFrame, reference: pd.DataFrame) -> dict[str, float]:
    """Root mean square of each motor's torque [N m or N]."""
    return {
        joint_name(joint_number(name)): float(np.sqrt(np.mean(log[name].to_numpy() ** 2)))
        for name in map(str, log)
        if is_torque(name)
    }


def peak_deformation(log: pd.DataFrame, reference: pd.DataFrame) -> dict[str, float]:
    """Largest size of each deformation [rad]."""
    return {name: float(np.abs(log[name].to_numpy()).max()) for name in map(str, log) if is_deformation(name)}


METRICS: dict[str, Metric] = {
    "tip_error": tip_error,
    "torque_rms": torque_rms,
    "peak_deformation": peak_deformation,
}


def evaluate(metrics: Mapping[str, Metric], log: pd.DataFrame, reference: pd.DataFrame) -> dict[str, float]:
    """Column name -> number. Raises ValueError naming the metric that fails or is not finite."""
    found: dict[str, float] = {}
    for name, metric in metrics.items():
        try:
            value = metric(log, reference)
            parts = (
                {f".{k}": float(v) for k, v in value.items()}
                if isinstance(value, Mapping)
                else {"": float(value)}
            )
        except (Exception, SystemExit) as error:
            raise ValueError(f"metric {name}: {type(error).__name__}: {error}") from None
        found |= {name + key: number for key, number in parts.items()}
    wild = [name for name, number in found.items() if not np.isfinite(number)]
    if wild:
        raise ValueError(f"metric {wild[0]} is {found[wild[0]]}")
    return found
