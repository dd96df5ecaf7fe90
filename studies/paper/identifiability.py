"""What can be identified: in principle, in these data, and what a threshold would make of it."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from flexmodels.robot import Robot
from pyident.conditioning.motion import Motion
from pyident.estimation.identify import Identified
from pyident.estimation.least_squares import solve
from pyident.regression.reduced import reduce
from pyident.regression.regressor import regressor
from pyident.rules.confidence import CONFIDENCE


def explanation(found: Identified, structural: np.ndarray) -> str:
    """Why the rank is what it is, with the numbers of these data."""
    s = found.solution.singular_values / found.solution.singular_values[0]
    rank, total = found.solution.rank, len(s)
    seen = int((structural > 1e-10 * structural[0]).sum())
    return (
        f"Of {total} parameters {seen} combinations appear in the equations at all (random "
        f"exact states with large deformations). One of them, m s_z of link 1 against the "
        f"bending stiffnesses k2 and k3 of joint 1, only in proportion to eps²: gravity on the "
        f"upright first link acts as a negative bending spring. In these data it lies at "
        f"{s[rank]:.1e} of the largest singular value, the next at {s[rank - 1]:.1e}, and is "
        f"lost in any noise: rank {rank}. The paper reports 64 for its arm. A rank of 64 would "
        f"need a threshold between {s[64]:.2f} and {s[63]:.2f}, where there is no gap: such "
        f"directions are less well excited, not undetermined."
    )


def structural_singular_values(robot: Robot, samples: int = 400) -> np.ndarray:
    """Singular values of the scaled regression matrix at random exact states, eps up to 0.3 rad."""
    rng = np.random.default_rng(0)
    size = (samples, len(robot.coordinates))
    q, dq, ddq = (rng.uniform(-1, 1, size) for _ in range(3))
    q[:, : len(robot.joints)] *= np.pi
    q[:, len(robot.joints) :] *= 0.3
    Phi = regressor(robot, Motion(q, dq, ddq)).matrix
    reduced = reduce([(Phi, np.ones(size))], robot.coordinates, tuple(robot.parameters))
    return solve(reduced).singular_values


def figure(found: Identified, structural: np.ndarray) -> Figure:
    s = found.solution.singular_values / found.solution.singular_values[0]
    fig = Figure(figsize=(9, 3.8), layout="constrained")
    left, right = fig.subplots(1, 2)
    number, rank = np.arange(1, len(s) + 1), found.solution.rank
    left.semilogy(
        number, np.maximum(structural / structural[0], 1e-17), ".", color="0.7", label="random exact states"
    )
    left.semilogy(number[:rank], s[:rank], "o", ms=3.5, label=f"data, determined: {rank}")
    left.semilogy(
        number[rank:], np.maximum(s[rank:], 1e-17), "x", color="C3", label=f"data, not: {len(s) - rank}"
    )
    left.set(xlabel="number", ylabel="singular value / largest")
    left.legend(frameon=False, fontsize=8)
    threshold = np.logspace(-10, 0, 500)
    right.semilogx(threshold, [(s > t).sum() for t in threshold], "C0")
    right.axhline(64, color="C3", lw=1, ls="--", label="the paper's 64")
    right.axhline(rank, color="0.6", lw=1, ls=":", label=f"by our rule: {rank}")
    right.set(xlabel="threshold / largest singular value", ylabel="rank", ylim=(0, len(s) + 4))
    right.legend(frameon=False, fontsize=8, loc="lower left")
    for ax in (left, right):
        ax.grid(alpha=0.3)
    return fig


def parameter_table(original: Robot, regression: Identified, corrected: Identified) -> pd.DataFrame:
    """Parameter by parameter: true value, both estimates, standard deviation, interval, support."""
    rows = []
    for i, (name, true) in enumerate(original.parameters.items()):
        alone = regression.support[name] == "alone"
        value, std = corrected.solution.p[i], corrected.solution.std[i]
        rows.append(
            {
                "parameter": name,
                "unit": original.units[name],
                "original": f"{true:.5g}",
                "regression": f"{regression.solution.p[i]:.5g}" if alone else "",
                "corrected": f"{value:.5g}" if alone else "",
                "error": f"{100 * (value / true - 1):+.2g} %" if alone and true else "",
                "std": f"{100 * std / abs(value):.2g} %" if alone else "",
                "95 %": f"{value - CONFIDENCE * std:.4g} … {value + CONFIDENCE * std:.4g}" if alone else "",
                "determined": regression.support[name],
            }
        )
    combinations = [
        {
            "parameter": b.expression,
            "regression": f"{b.value:.5g}",
            "std": f"{100 * b.std / abs(b.value):.2g} %" if b.value else "",
            "determined": "together",
        }
        for b in regression.base
        if len(b.terms) > 1
    ]
    return pd.DataFrame(rows + combinations).fillna("")
