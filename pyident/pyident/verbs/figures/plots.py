"""Figures of outcomes, for notebooks and scripts."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pyident.rules.confidence import CONFIDENCE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pyident.diagnosis.result import Row
    from pyident.estimation.base_parameters import BaseParameter
    from pyident.extension.waterfall import Step


def over_floor(panels: Mapping[str, Sequence[tuple[str, float]]]) -> "Figure":
    """Bars of a ratio to the floor, a panel per log; 1 is the floor."""
    from matplotlib.figure import Figure

    longest = max(len(bars) for bars in panels.values())
    figure = Figure(figsize=(7, max(2.0, 0.28 * longest) * len(panels)), layout="constrained")
    for axes, (title, bars) in zip(np.atleast_1d(figure.subplots(len(panels))), panels.items(), strict=True):
        axes.barh([name for name, _ in bars], [ratio for _, ratio in bars])
        axes.axvline(1.0, color="k", lw=1)
        axes.invert_yaxis()
        axes.set(title=title, xlabel="error over the floor", xscale="log")
    return figure


def determination(base: Sequence["BaseParameter"]) -> "Figure":
    """Bars of the 95 % interval over the value of every base parameter; beyond 1 its sign is open."""
    from matplotlib.figure import Figure

    told = [b for b in base if np.isfinite(b.std) and b.value]
    figure = Figure(figsize=(7, 0.8 + 0.22 * len(told)), layout="constrained")
    axes = figure.subplots()
    axes.barh([b.expression for b in told], [CONFIDENCE * b.std / abs(b.value) for b in told])
    axes.axvline(1.0, color="k", lw=1)
    axes.invert_yaxis()
    axes.set(xlabel="half of the 95 % interval over the value", xscale="log")
    return figure


def waterfall(steps: Sequence["Step"]) -> "Figure":
    """Errors over their floors, without and with an effect."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 0.8 + 0.5 * len(steps)), layout="constrained")
    axes, at = figure.subplots(), np.arange(len(steps))
    axes.barh(at - 0.2, [s.before / s.floor for s in steps], height=0.4, label="without", color="0.7")
    axes.barh(at + 0.2, [s.after / s.floor for s in steps], height=0.4, label="with")
    axes.axvline(1.0, color="k", lw=1)
    axes.set_yticks(at, [f"{s.name}, {s.data}" for s in steps])
    axes.invert_yaxis()
    axes.set(xlabel="error over the floor", xscale="log")
    axes.legend()
    return figure


def heat_map(rows: Sequence["Row"]) -> "Figure":
    """Residual over the floor: equations by bands of frequency."""
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    ratio = np.array([row.over_floor for row in rows])
    figure = Figure(figsize=(7, 0.8 + 0.35 * len(rows)), layout="constrained")
    axes = figure.subplots()
    norm = LogNorm(1.0, max(2.0, float(np.nanmax(ratio))))
    image = axes.imshow(np.maximum(ratio, 1.0), aspect="auto", cmap="OrRd", norm=norm)
    axes.set_yticks(range(len(rows)), [row.coordinate for row in rows])
    axes.set_xticks(range(ratio.shape[1]), [f"{low:g}–{high:.3g}" for low, high in rows[0].bands])
    axes.set_xlabel("frequency [Hz]")
    figure.colorbar(image, label="residual over the floor")
    return figure
