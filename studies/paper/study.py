"""The paper's section 3: identify the simulated arm and let both models follow a straight line."""

from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from flexmodels.experiment import identification, line
from flexmodels.robot import Line, Robot
from flexmodels.robot_file import load_robot, save_robot
from pyident.identify import Identified, identify
from pyident.log import Log, write_log
from pyident.pipeline import simulate_robot
from pyident.studies import StudyResult, row

TIP = ["tip.x", "tip.y", "tip.z"]
DIRECTIONS = {"vertical": 2, "horizontal": 1}  # across the line, base axes z and y


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Simulate, identify, validate; figures, the identified robot and both logs go to `folder`."""
    original = load_robot("four_link")
    log = Log(
        simulate_robot(original, identification(original), lambda f: progress(0.4 * f)), "identification"
    )
    write_log(log, folder / "identification.parquet")
    found = identify(original, [log])
    save_robot(found.robot, folder / "identified.toml")

    plan = line(original)
    runs = {
        "original": simulate_robot(original, plan, lambda f: progress(0.6 + 0.2 * f)),
        "identified": simulate_robot(found.robot, plan, lambda f: progress(0.8 + 0.2 * f)),
    }
    assert original.line is not None
    deviation = runs["original"][TIP].to_numpy() - _wanted(original.line, plan.time)
    difference = (runs["identified"][TIP] - runs["original"][TIP]).to_numpy()
    figures = [
        _tip_figure(folder, plan.time, deviation, difference),
        _singular_figure(folder, found),
    ]
    return StudyResult(_rows(original, found, deviation, difference, runs), figures)


def _wanted(plan: Line, time: np.ndarray) -> np.ndarray:
    s = time / plan.duration
    s = 10 * s**3 - 15 * s**4 + 6 * s**5
    return np.array(plan.start) + np.outer(s, np.subtract(plan.end, plan.start))


def _rows(
    original: Robot,
    found: Identified,
    deviation: np.ndarray,
    difference: np.ndarray,
    runs: dict[str, pd.DataFrame],
) -> list[dict[str, str]]:
    rows = []
    for name, axis in DIRECTIONS.items():
        factor = _rms(deviation[:, axis]) / _rms(difference[:, axis])
        text = f"{1e3 * _rms(difference[:, axis]):.3g} mm, {factor:.0f} times below the deviation"
        rows.append(row(f"tip difference, {name} (rms)", text, "10 times", factor >= 10))
    for k, _ in original.numbered:
        column = f"joint{k}.tau"
        torque = runs["original"][column]
        error = _rms(runs["identified"][column] - torque)
        rows.append(row(f"torque difference, joint {k} (rms)", f"{error:.2g} of {_rms(torque):.3g} N m"))
    errors = [
        100 * (found.robot.parameters[f"joint{k}.k[1]"] / original.parameters[f"joint{k}.k[1]"] - 1)
        for k, _ in original.numbered
    ]
    text = ", ".join(f"{error:+.2f} %" for error in errors)
    rows.append(row("drive stiffness, joints 1 to 4", text, "2 %", max(map(abs, errors)) <= 2))
    rows.append(
        row("rank", f"{found.solution.rank} of {len(found.reduced.columns)} (the paper's arm: 64 of 76)")
    )
    text = ", ".join(f"{v:.1f} %" for v in found.relative_error.values())
    rows.append(row("relative torque error, joints 1 to 4 and all", text))
    return rows


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _tip_figure(folder: Path, time: np.ndarray, deviation: np.ndarray, difference: np.ndarray) -> Path:
    """The four panels of the paper's figure 7."""
    fig, axes = plt.subplots(2, 2, figsize=(9, 5.6), sharex=True, sharey="row", layout="constrained")
    panels = [
        ("original: deviation from the line", deviation, "C0"),
        ("identified minus original", difference, "C3"),
    ]
    for i, (title, values, colour) in enumerate(panels):
        for j, (name, axis) in enumerate(DIRECTIONS.items()):
            ax = axes[i, j]
            ax.plot(time, 1e3 * values[:, axis], colour, lw=1.2)
            factor = _rms(deviation[:, axis]) / _rms(values[:, axis])
            below = f", rms {factor:.0f} times smaller" if i else ""
            ax.set_title(f"({'abcd'[2 * i + j]}) {title}, {name}{below}", fontsize=9, loc="left")
            ax.grid(alpha=0.3)
        axes[i, 0].set_ylabel("tip [mm]")
    for ax in axes[1]:
        ax.set_xlabel("time [s]")
    fig.suptitle("Tip on a straight line of 1.7 m in 2.5 s", fontsize=10)
    return _save(fig, folder / "tip.png")


def _singular_figure(folder: Path, found: Identified) -> Path:
    s = found.solution.singular_values
    rank = found.solution.rank
    fig, ax = plt.subplots(figsize=(7, 3.6), layout="constrained")
    order = np.arange(1, len(s) + 1)
    values = np.maximum(s / s[0], 1e-17)
    ax.semilogy(order[:rank], values[:rank], "o", ms=3.5, label=f"determined by the data: {rank}")
    ax.semilogy(order[rank:], values[rank:], "x", ms=5, color="C3", label=f"not determined: {len(s) - rank}")
    ax.set(
        xlabel="number",
        ylabel="singular value / largest",
        title="Regression matrix, columns scaled to unit length",
    )
    ax.title.set_fontsize(10)
    ax.legend(frameon=False)
    ax.grid(alpha=0.3)
    return _save(fig, folder / "singular_values.png")


def _save(fig, path: Path) -> Path:
    fig.savefig(path, dpi=130)
    plt.close(fig)
    return path
