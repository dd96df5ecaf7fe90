"""Frequency responses of the models, linearised about a pose."""

import casadi as ca
import numpy as np
from matplotlib.figure import Figure

from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot


def figure(models: dict[str, Robot], pose: float = np.pi / 4) -> Figure:
    """Torque to acceleration of the same joint, every joint at `pose` rad, sliding forward."""
    frequency = np.logspace(0, np.log10(300), 600)
    joints = len(next(iter(models.values())).joints)
    fig = Figure(figsize=(9, 5.4), layout="constrained")
    axes = fig.subplots(2, (joints + 1) // 2, sharex=True)
    for style, (name, robot) in zip(("-", "--", ":"), models.items(), strict=False):
        gains = np.abs(responses(robot, np.full(joints, pose), frequency))
        for k, ax in enumerate(axes.flat[:joints]):
            ax.loglog(frequency, gains[:, k], style, lw=1.2, label=name)
    for k, ax in enumerate(axes.flat[:joints], start=1):
        ax.set_title(f"joint {k}", fontsize=9, loc="left")
        ax.grid(alpha=0.3, which="both")
    for ax in axes[-1]:
        ax.set_xlabel("frequency [Hz]")
    for ax in axes[:, 0]:
        ax.set_ylabel("acceleration / torque [1/(kg m²)]")
    axes.flat[0].legend(frameon=False, fontsize=8)
    return fig


def responses(robot: Robot, e: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """(F, joints) complex gains from each motor torque [N m] to its joint's acceleration [rad/s2]."""
    eq = equations(robot)
    n, joints = len(eq.coordinates), eq.joints
    x, u, p = ca.SX.sym("x", 2 * n), ca.SX.sym("u", joints), list(eq.parameters.values())
    dx = eq.rates(x, u, p, np.ones(joints))[0]
    jacobians = ca.Function("jacobians", [x, u], [ca.jacobian(dx, x), ca.jacobian(dx, u)])
    A, B = (np.array(v) for v in jacobians(np.r_[e, np.zeros(2 * n - joints)], np.zeros(joints)))
    out = np.empty((len(frequency), joints), dtype=complex)
    for i, f in enumerate(frequency):
        s = 2j * np.pi * f
        states = np.linalg.solve(s * np.eye(2 * n) - A, B)
        out[i] = s * np.diag(states[n : n + joints])
    return out
