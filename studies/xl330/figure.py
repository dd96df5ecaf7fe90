"""The XL330 study's figure: errors at held-out gains, and every log with its simulation."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pyident.refinement.closed_loop import ServoLog

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw(
    bars: Sequence[tuple[int, float, dict[str, float]]],
    recordings: Sequence[tuple[str, ServoLog]],
    replays: Sequence[tuple[pd.DataFrame, np.ndarray]],
) -> "Figure":
    """bars: gain, our error and the ladder's [degrees]; the logs in rows of three gains."""
    from matplotlib.figure import Figure

    rows = len(recordings) // 3
    figure = Figure(figsize=(12, 2.4 * (rows + 1)), layout="constrained")
    axes = figure.subplots(rows + 1, 3)
    for axis, (gain, ours, theirs) in zip(axes[0], bars, strict=True):
        axis.bar(["this model", *theirs], [ours, *theirs.values()], color=["C1"] + ["C7"] * len(theirs))
        axis.set_title(f"kp {gain} held out")
        axis.set_ylabel("mean |error| [°]")
        axis.tick_params(axis="x", rotation=45)
    for axis, (name, recording), (frame, error) in zip(axes[1:].flat, recordings, replays, strict=True):
        measured = recording.log.frame
        axis.plot(measured["time"], np.degrees(measured["joint1.r"]), color="C7", lw=0.7, label="command")
        axis.plot(measured["time"], np.degrees(measured["joint1.e"]), color="C0", label="measured")
        seconds = frame["time"] + measured["time"].iloc[0]
        axis.plot(seconds, np.degrees(frame["joint1.e"]), color="C1", ls="--", label="simulated")
        axis.set_title(f"{name}: {np.degrees(np.abs(error).mean()):.2f}°", fontsize=9)
        axis.set_ylabel("position [°]")
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    axes[1, 0].legend(fontsize=7)
    return figure
