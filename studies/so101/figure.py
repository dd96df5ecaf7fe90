"""The SO-101 study's figure: each motion's error beside its tracking error, and the elbow over time."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pyident.refinement.closed_loop import ServoLog

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ELBOW = 3
_SECONDS = 30.0


def draw(
    recordings: Mapping[str, ServoLog],
    errors: Mapping[str, tuple[pd.DataFrame, float]],
    fitted: Sequence[str],
) -> "Figure":
    """errors: per motion its simulation and simulated − measured position, rms [rad]."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 13), layout="constrained")
    grid = figure.add_gridspec(5, 3)
    axis = figure.add_subplot(grid[0, :])
    names = list(recordings)
    frames = [recording.log.frame for recording in recordings.values()]
    joints = range(1, 7)
    tracking = [_rms(np.array([f[f"joint{k}.e"] - f[f"joint{k}.r"] for k in joints])) for f in frames]
    at = np.arange(len(names))
    axis.bar(at - 0.2, tracking, 0.4, color="C7", label="measured − commanded")
    ours = [np.degrees(errors[name][1]) for name in names]
    axis.bar(at + 0.2, ours, 0.4, color="C1", label="simulated − measured")
    labels = [name.replace("_", "\n") + ("\n(fitted)" if name in fitted else "") for name in names]
    axis.set_xticks(at, labels, fontsize=7)
    axis.set_ylabel("rms over the joints [°]")
    axis.legend()
    for i, (name, frame) in enumerate(zip(names, frames, strict=True)):
        axis = figure.add_subplot(grid[1 + i // 3, i % 3])
        seconds = frame["time"] - frame["time"].iloc[0]
        part = seconds < _SECONDS
        simulated = errors[name][0][f"joint{_ELBOW}.e"]
        axis.plot(
            seconds[part], np.degrees(frame[f"joint{_ELBOW}.r"][part]), color="C7", lw=0.8, label="command"
        )
        axis.plot(seconds[part], np.degrees(frame[f"joint{_ELBOW}.e"][part]), color="C0", label="measured")
        axis.plot(seconds[part], np.degrees(simulated[part]), color="C1", ls="--", label="simulated")
        axis.set_title(f"{name}: elbow", fontsize=9)
        axis.set_ylabel("[°]")
        if i >= len(names) - 3:
            axis.set_xlabel("time [s]")
        if i == 0:
            axis.legend(fontsize=7)
    return figure


def _rms(errors: np.ndarray) -> float:
    return float(np.degrees(np.sqrt(np.mean(np.square(errors)))))
