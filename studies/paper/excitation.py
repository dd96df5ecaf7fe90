"""The experiment: what is excited, and how fast the closed loop is."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from flexmodels.coordinate import motor_of
from flexmodels.experiment import Experiment
from flexmodels.multisine import crest_factor
from flexmodels.robot import Robot
from pyident.simulation.fmu_runs import simulate_robot


@dataclass(frozen=True)
class Loop:
    """From reference to joint angle at the lines [Hz]: complex gain; bandwidth [Hz] at -3 dB."""

    frequency: np.ndarray
    gain: np.ndarray

    @property
    def bandwidth(self) -> float:
        below = np.flatnonzero(np.abs(self.gain) < 1 / np.sqrt(2))
        return float(self.frequency[below[0]]) if len(below) else float("nan")


def bandwidths(robot: Robot, amplitude: float = 0.02, speed: float = 1.0) -> dict[str, Loop]:
    """Measured on the simulated arm, joint by joint.

    Every joint turns steadily, so that friction is constant; one joint's reference carries a multisine of
    `amplitude` [rad] rms, whose second period counts.
    """
    assert robot.controller is not None
    period, rate = 4.0, robot.controller.rate
    time = np.arange(round(2 * period * rate) + 1) / rate
    lines = np.arange(2, 161) / period
    phases = np.random.default_rng(0).uniform(0, 2 * np.pi, len(lines))
    tones = np.sin(2 * np.pi * np.outer(time, lines) + phases) / lines
    shape = tones.sum(axis=1)
    shape *= amplitude / np.sqrt(np.mean(shape**2))
    ramp = 0.5 * speed * time * np.minimum(time, 1)
    steady = np.outer(np.where(time < 1, ramp, 0.5 * speed + speed * (time - 1)), [0.2, 0.1, 0.1, 0.2])
    quiet, loops = simulate_robot(robot, Experiment(time, steady, 0 * steady)), {}
    for k, _ in robot.numbered:
        reference = steady.copy()
        reference[:, k - 1] += shape - shape[0]
        run = simulate_robot(robot, Experiment(time, reference, 0 * steady))
        last = slice(len(time) - 1 - round(period * rate), len(time) - 1)
        out = np.fft.rfft((run[motor_of(k)] - quiet[motor_of(k)]).to_numpy()[last])
        into = np.fft.rfft((reference - steady)[last, k - 1])
        at = np.round(lines * period).astype(int)
        loops[f"joint {k}"] = Loop(lines, out[at] / into[at])
    return loops


def closed_loop_figure(loops: dict[str, Loop]) -> Figure:
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    ax = figure.subplots()
    for name, loop in loops.items():
        ax.semilogx(
            loop.frequency, 20 * np.log10(np.abs(loop.gain)), label=f"{name}: {loop.bandwidth:.1f} Hz"
        )
    ax.axhline(-3, color="0.5", lw=1, ls="--")
    ax.set(xlabel="frequency [Hz]", ylabel="reference to angle [dB]", ylim=(-40, 15))
    ax.legend(frameon=False, fontsize=8)
    ax.grid(alpha=0.3, which="both")
    return figure


def spectrum_figure(plan: Experiment) -> Figure:
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    window = np.hanning(len(plan.time))
    frequency = np.fft.rfftfreq(len(plan.time), plan.time[1])
    for k, torque in enumerate(plan.feedforward.T, start=1):
        left.plot(plan.time[:500], torque[:500], lw=0.8)
        level = np.abs(np.fft.rfft(window * torque)) / window.sum() * 2
        label = f"joint {k}, crest factor {crest_factor(torque):.1f}"
        right.semilogy(frequency, np.maximum(level, 1e-6), lw=0.7, label=label)
    right.axvline(50, color="0.5", lw=1, ls="--")
    left.set(xlabel="time [s]", ylabel="feed-forward torque [N m]")
    right.set(xlabel="frequency [Hz]", ylabel="amplitude [N m]", ylim=(1e-6, 50))
    right.legend(frameon=False, fontsize=7)
    for ax in (left, right):
        ax.grid(alpha=0.3)
    return figure
