"""MuJoCo moves the machine under a PI-D controller, with the encoders' rounding inside the loop."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from flexmodels.robot import RobotError

from .laws import Law, State
from .machines import Machine
from .motions import Course
from .sensors import Sensors, rounded

_FAST = 10.0  # Hz: what a loop makes of its encoders' noise lies above
STEP = 1e-3  # s, of the physics and of the controller
_FILTER = 0.1  # of the speed, first order: 16 Hz
_BANDWIDTH = 2 * np.pi * 4.0  # rad/s, of the loop


@dataclass(frozen=True)
class Hidden:
    """A law at a joint (from 0) with its amplitude [N m or N]."""

    law: Law
    joint: int
    amplitude: float


def simulated(
    machine: Machine, plan: Course, hidden: Sequence[Hidden], sensors: Sensors, duration: float, every: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """time (N,), what encoders read and the motors' torques (N, n), at every `every`-th step."""
    mujoco = _mujoco()
    model = _model(mujoco, machine)
    data, n = mujoco.MjData(model), len(machine.rotor)
    time = np.arange(0, duration, STEP)
    reference, speed, _ = plan.at(time)
    data.qpos[:], data.qvel[:] = reference[0], speed[0]
    mujoco.mj_forward(model, data)
    inertia = _inertia(mujoco, model, data)
    kp, kd, ki = inertia * _BANDWIDTH**2, 1.6 * inertia * _BANDWIDTH, inertia * _BANDWIDTH**3 / 4
    integral, before, rate = data.qfrc_bias.copy(), rounded(reference[0], sensors, machine.sliders), speed[0]
    read, torques, full, late = [], [], np.zeros((n, n)), [reference[0]] * round(sensors.delay / STEP)
    for i in range(len(time)):
        late.append(data.qpos.copy())
        encoder = rounded(late.pop(0), sensors, machine.sliders)
        rate = rate + _FILTER * ((encoder - before) / STEP - rate) if i else rate
        before, error = encoder, reference[i] - encoder
        integral = integral + ki * error * STEP
        tau = integral + kp * error + kd * (speed[i] - rate)
        if i % every == 0:
            read.append(encoder)
            torques.append(tau)
        mujoco.mj_fullM(model, data, full)
        load = data.qfrc_bias + full @ data.qacc - machine.rotor * data.qacc
        state = State(time[i : i + 1], data.qpos[None], data.qvel[None], load[None])
        _apply(data, model, machine, hidden, state, tau)
        mujoco.mj_step(model, data)
    read, torques = np.array(read), np.array(torques)
    off = np.abs(read - reference[::every]).max()
    if not np.isfinite(torques).all() or off > 0.5:
        raise FloatingPointError("the loop does not hold the machine")
    return time[::every], read, torques


def loop_noise(torques: np.ndarray, period: float) -> np.ndarray:
    """Standard deviation (n,) of what a loop's torques (N, n) have above 10 Hz, by the median of its size."""
    fast = sosfiltfilt(butter(4, 2 * _FAST * period, "high", output="sos"), torques, axis=0)
    return 1.4826 * np.median(np.abs(fast), axis=0)


def spread_above(noise: np.ndarray, count: int, period: float) -> np.ndarray:
    """(count, n) at frequencies up to Nyquist's: variance of such noise (n,), which on average is its own."""
    above = np.linspace(0, 0.5 / period, count) > _FAST
    return np.square(noise) * above[:, None] / above.mean()


def _apply(data: Any, model: Any, machine: Machine, hidden: Sequence[Hidden], s: State, tau) -> None:
    """The motors' torques and everything that MuJoCo's own joints do not have, for one step."""
    level, force = machine.coulomb.copy(), tau - machine.viscous * s.v[0]
    for h in hidden:
        amount = h.amplitude * h.law.force(s, h.joint)[0]
        if h.law.dry:
            level[h.joint] += amount
        else:
            force[h.joint] -= amount
    model.dof_frictionloss[:] = np.maximum(level, 0)
    data.qfrc_applied[:] = force


def _inertia(mujoco: Any, model: Any, data: Any) -> np.ndarray:
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return np.diag(full).copy()


def _model(mujoco: Any, machine: Machine) -> Any:
    """Bodies parallel to the base in the zero pose, one in the other."""
    spec, robot = mujoco.MjSpec(), machine.robot
    spec.option.timestep, spec.option.gravity = STEP, robot.gravity
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    body = spec.worldbody
    for (k, joint), link in zip(robot.numbered, robot.links, strict=True):
        com, J = link.about_centre()
        body = body.add_body(name=f"link{k}", pos=joint.origin, mass=link.m, ipos=com)
        body.explicitinertial = True
        body.fullinertia = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
        kind = "mjJNT_HINGE" if joint.kind == "revolute" else "mjJNT_SLIDE"
        body.add_joint(
            name=f"joint{k}",
            type=getattr(mujoco.mjtJoint, kind),
            axis=joint.x,
            armature=machine.rotor[k - 1],
            frictionloss=machine.coulomb[k - 1],
        )
    return spec.compile()


def _mujoco() -> Any:
    try:
        return import_module("mujoco")
    except ImportError:
        raise RobotError(
            "MuJoCo is missing, which moves machines of this study; pip install 'flexident[mujoco]'"
        ) from None
