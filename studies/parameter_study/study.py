"""Which stiffness and which friction does the tip's path depend on?"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pyident.sweep.plan import StudyPlan, load_study_plan
from pyident.sweep.run import run_plan
from pyident.sweep.studies import StudyResult, row
from pyident.sweep.summary import failures

PLAN = Path(__file__).with_name("plan.toml")
# result -> title, unit, factor from SI
SHOWN = {
    "tip_error.max": ("largest tip error", "mm", 1e3),
    "torque_rms.joint2": ("rms torque, joint 2", "N m", 1.0),
    "peak_deformation.joint2.eps[1]": ("peak twist, joint 2", "mrad", 1e3),
}


def run(folder: Path, progress: Callable[[float], None], runs: int | None = None) -> StudyResult:
    """Run the plan; table, sensitivities and figure go to `folder`. runs: of its design, none: all."""
    plan = load_study_plan(PLAN)
    if runs is not None:
        plan = replace(plan, design=plan.design.head(runs))
    table = run_plan(plan, folder, progress=progress)
    found = pd.read_csv(folder / "sensitivity.csv", index_col=["result", "parameter"])
    path = folder / "sensitivity.png"
    figure(found).savefig(path, dpi=130)
    return StudyResult(_rows(plan, table, found), [path, folder / "results.parquet"], failures(table))


def figure(found: pd.DataFrame) -> Figure:
    """Morris' mu* with its 95 % interval, and sigma, per parameter; the most influential on top."""
    order = found.loc["tip_error.max", "mu_star"].sort_values().index
    fig = Figure(figsize=(10, 5.2), layout="constrained")
    axes = fig.subplots(1, len(SHOWN), sharey=True)
    for ax, (result, (title, unit, factor)) in zip(axes, SHOWN.items(), strict=True):
        part = factor * found.loc[result].loc[order]
        ax.barh(order, part["mu_star"], xerr=part["mu_star_conf"], color="tab:blue", error_kw={"lw": 0.8})
        ax.plot(part["sigma"], order, "k|", ms=8, label="sigma: interaction, curvature")
        ax.set_title(title, fontsize=9, loc="left")
        ax.set_xlabel(f"mean effect of the whole range [{unit}]")
        ax.set_xlim(left=0)
        ax.grid(alpha=0.3, axis="x")
    axes[0].legend(frameon=False, fontsize=8, loc="lower right")
    return fig


def _rows(plan: StudyPlan, table: pd.DataFrame, found: pd.DataFrame) -> list[dict[str, str]]:
    failed = int(np.count_nonzero(table["failure"] != ""))
    rows = [row("runs; failed", f"{len(table)}; {failed}", "all; 0", failed == 0)]
    for result, (title, unit, factor) in SHOWN.items():
        low, high = factor * table[result].min(), factor * table[result].max()
        effects = found.loc[result]["mu_star"]
        most = effects.idxmax()
        text = f"{low:.3g} to {high:.3g} {unit}; most by {most} ({factor * effects[most]:.2g} {unit})"
        rows.append(row(f"{title}, {len(plan.ranges)} parameters ± 25 %", text))
    return rows
