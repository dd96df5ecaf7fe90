"""Both models on the straight line: figures 6 and 7 and the torques."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from flexmodels.coordinate import torque_of
from flexmodels.experiment import Experiment, line_profile
from flexmodels.robot import Robot

TIP = ["tip.x", "tip.y", "tip.z"]
DIRECTIONS = {"vertical": 2, "horizontal": 1}  # across the line: base axes z and y


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@dataclass(frozen=True)
class Tip:
    """The simulated runs on the line, by model; the first is the original."""

    robot: Robot
    plan: Experiment
    runs: dict[str, pd.DataFrame]

    @property
    def identified(self) -> list[str]:
        return list(self.runs)[1:]

    @property
    def deviation(self) -> np.ndarray:
        """(N, 3) original minus wanted line [m]."""
        plan = self.robot.settings.line
        assert plan is not None
        s = line_profile(self.plan.time / plan.duration)
        wanted = np.array(plan.start) + np.outer(s, np.subtract(plan.end, plan.start))
        return self.runs["original"][TIP].to_numpy() - wanted

    def difference(self, model: str) -> np.ndarray:
        """(N, 3) model minus original [m]."""
        return (self.runs[model][TIP] - self.runs["original"][TIP]).to_numpy()

    def difference_rms(self, model: str, direction: str) -> float:
        return rms(self.difference(model)[:, DIRECTIONS[direction]])

    def factor(self, model: str, direction: str) -> float:
        """rms of the deviation over rms of the difference."""
        return rms(self.deviation[:, DIRECTIONS[direction]]) / self.difference_rms(model, direction)

    def torque_difference(self, model: str, joint: int) -> float:
        column = torque_of(joint)
        return rms(self.runs[model][column] - self.runs["original"][column])

    def torque_variation(self, joint: int) -> float:
        """rms of the original's torque on the line."""
        return rms(self.runs["original"][torque_of(joint)])


def tip_figure(tip: Tip) -> Figure:
    """The four panels of figure 7, the lower two for each way of identifying."""
    rows = 1 + len(tip.identified)
    figure = Figure(figsize=(9, 2.4 * rows + 0.4), layout="constrained")
    axes = figure.subplots(rows, 2, sharex=True, sharey="row")
    for j, (direction, axis) in enumerate(DIRECTIONS.items()):
        axes[0, j].plot(tip.plan.time, 1e3 * tip.deviation[:, axis], "C0", lw=1.2)
        axes[0, j].set_title(
            f"({'ab'[j]}) original: deviation from the line, {direction}", fontsize=9, loc="left"
        )
        for i, model in enumerate(tip.identified, start=1):
            axes[i, j].plot(tip.plan.time, 1e6 * tip.difference(model)[:, axis], "C3", lw=1.2)
            factor = f"rms {tip.factor(model, direction):.2g} times smaller"
            axes[i, j].set_title(f"({'cd'[j]}) {model}, {direction}: {factor}", fontsize=9, loc="left")
        axes[-1, j].set_xlabel("time [s]")
    for ax in axes.flat:
        ax.grid(alpha=0.3)
    axes[0, 0].set_ylabel("tip [mm]")
    for ax in axes[1:, 0]:
        ax.set_ylabel("minus original [µm]")
    return figure


def path_figure(tip: Tip) -> Figure:
    """Figure 6: the line from A to B in the horizontal plane, with the deviation magnified beside it."""
    figure = Figure(figsize=(9, 3), layout="constrained")
    ax = figure.subplots()
    plan, run = tip.robot.settings.line, tip.runs["original"]
    assert plan is not None
    ax.plot([plan.start[0], plan.end[0]], [plan.start[1], plan.end[1]], "k--", lw=1, label="wanted line")
    ax.plot(
        run["tip.x"], run["tip.y"] + 99 * tip.deviation[:, 1], "C0", label="original, deviation 100 times"
    )
    for name, (x, y, _) in (("A", plan.start), ("B", plan.end)):
        ax.annotate(name, (x, y), xytext=(0, 8), textcoords="offset points")
    ax.plot(0, 0, "ks", ms=8, label="base")
    ax.set(xlabel="x [m]", ylabel="y [m]", ylim=(-0.1, 0.6))
    ax.legend(frameon=False, fontsize=8, loc="lower right")
    ax.grid(alpha=0.3)
    return figure


def torque_figure(tip: Tip) -> Figure:
    joints = [k for k, _ in tip.robot.numbered]
    figure = Figure(figsize=(9, 1.7 * len(joints)), layout="constrained")
    axes = figure.subplots(len(joints), 2, sharex=True)
    for i, k in enumerate(joints):
        axes[i, 0].plot(tip.plan.time, tip.runs["original"][torque_of(k)], "C0", lw=1)
        for n, model in enumerate(tip.identified):
            difference = tip.runs[model][torque_of(k)] - tip.runs["original"][torque_of(k)]
            axes[i, 1].plot(tip.plan.time, difference, f"C{n + 1}", lw=0.8, label=model)
        axes[i, 0].set_ylabel(f"joint {k} [N m]")
        for ax in axes[i]:
            ax.grid(alpha=0.3)
    axes[0, 0].set_title("original", fontsize=9, loc="left")
    axes[0, 1].set_title("identified minus original", fontsize=9, loc="left")
    axes[0, 1].legend(frameon=False, fontsize=8)
    axes[-1, 0].set_xlabel("time [s]")
    axes[-1, 1].set_xlabel("time [s]")
    return figure
