"""The FMU's icon: the arm's links as lines, its hinges as discs."""

from collections.abc import Sequence
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from flexmodels.mechanics.plant import Equations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ICONS: dict[int, tuple[str, ...]] = {2: ("png",), 3: ("png", "svg")}  # by version of the standard
_BEND = 1.0  # [rad] so that a stretched arm shows its joints
_SIZE = 2.56  # [inch]


def icons(equations: Equations, kinds: Sequence[str]) -> dict[str, bytes]:
    """`icon.png` (256 x 256) and `icon.svg`, as far as wanted: the view that shows most of the arm."""
    from matplotlib import rc_context

    figure = _drawing(_flattened(equations))
    out = {}
    for kind in kinds:
        content = BytesIO()
        metadata = {"Date": None} if kind == "svg" else {"Software": None}
        with rc_context({"svg.hashsalt": equations.name}):
            figure.savefig(content, format=kind, dpi=100, transparent=True, metadata=metadata)
        out[f"icon.{kind}"] = content.getvalue()
    return out


def _flattened(equations: Equations) -> np.ndarray:
    """Ends of the lines, (lines, 2, 2): seen along the direction in which the arm is thinnest."""
    q = np.zeros(equations.skeleton.numel_in(0))
    for k in range(equations.joints):
        q[k] = 0.3 if equations.prismatic[k] else _BEND * (-1) ** k
    lines = np.array(equations.skeleton(q)).T.reshape(-1, 2, 3)
    lines = lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 1e-9]
    if not len(lines):
        return np.zeros((1, 2, 2))  # hinge and tip in one point
    points = lines.reshape(-1, 3)
    _, _, axes = np.linalg.svd(points - points.mean(axis=0))
    return lines @ axes[:2].T


def _drawing(lines: np.ndarray) -> "Figure":
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_SIZE, _SIZE))
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    for start, end in lines:
        ax.plot(*zip(start, end, strict=True), color="#3b6ea5", lw=10, solid_capstyle="round", zorder=1)
    for i, (start, _) in enumerate(lines):
        ax.plot(*start, "s" if i == 0 else "o", ms=24 if i == 0 else 18, mfc="white", mec="#1d2b3a", mew=4)
    ax.plot(*lines[-1, 1], "D", ms=10, color="#d9822b")
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.2)
    return figure
