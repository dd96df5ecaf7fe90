"""Runs an arm in its closed loop and writes down what sensors would have shown."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd

from flexmodels.coordinate import deformation_of, joint_name, motor_of, of_joint, torque_of
from flexmodels.robot import Robot

from .laws import LAWS, Levels
from .machine import Machine
from .model import Arm

STEPS = 40  # per controller period: 0.1 ms at 250 Hz


class UnstableLoop(RuntimeError):
    """The arm with its hidden law runs away under its controller: nobody could have measured it."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the sensors: motor encoder, deformations [rad], tip [m]."""

    e: float = 2e-6
    eps: float = 1e-6
    tip: float = 5e-6


NOISELESS = Noise(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Plan:
    """One experiment. Per joint unless said otherwise; empty tuples stand for the robot file's plan.

    start, drift   reference at the start [rad], constant speed under it [rad/s]
    swing, period  reference + swing/2 (1 - cos(2 pi t / period)) [rad], [s]
    rms            of the feed-forward multisine [N m], `lines` from `lowest` to `highest` Hz (all joints)
    lead           seconds that are run, with the drift ramped up, before the log starts
    payload        whether a payload, if the case has one, is on
    pace           speed between points of `swing`'s range, with dwells, in place of all this [rad/s]; 0: none
    """

    duration: float = 20.0
    start: tuple[float, ...] = ()
    drift: tuple[float, ...] = ()
    swing: tuple[float, ...] = ()
    period: tuple[float, ...] = ()
    rms: tuple[float, ...] = ()
    lines: int = 204
    lowest: float = 0.12
    highest: float = 50.0
    lead: float = 0.0
    payload: bool = True
    pace: float = 0.0


def standard(robot: Robot, **changes) -> Plan:
    """The robot file's identification experiment, 20 s long."""
    own, n = robot.settings.identification, len(robot.joints)
    if own is None:
        raise ValueError(f"robot {robot.name} has no [identification], from which plans are made")
    tones = own.multisine
    plan = Plan(
        start=(0.0,) * n,
        drift=(0.0,) * n,
        swing=tuple(own.swing),
        period=(own.period,) * n,
        rms=tuple(tones.rms),
        lines=tones.lines,
        lowest=tones.lowest,
        highest=tones.highest,
    )
    return replace(plan, **changes)


@dataclass(frozen=True)
class Hidden:
    """A law at a joint with its constants."""

    law: str
    joint: int
    constants: Mapping[str, float] = field(default_factory=dict)


def build(robot: Robot, laws: Sequence[Hidden]) -> Arm:
    """The robot with its hidden laws; a constant is the number `joint<k>.<law>.<constant>`."""
    arm = Arm(robot, tilting=any(LAWS[h.law].tilting for h in laws))
    for h in laws:
        c = {n: arm.number(f"joint{h.joint}.{h.law}.{n}", value) for n, value in h.constants.items()}
        LAWS[h.law].add(arm, h.joint, c, dict(h.constants))
    return arm


def simulate(
    robot: Robot,
    laws: Sequence[Hidden],
    plan: Plan,
    seed: int,
    noise: Noise = Noise(),
    steps: int = STEPS,
) -> pd.DataFrame:
    """One log in the contract's columns. `seed`: of the multisine's phases, noise, per-log constants."""
    return simulate_all(robot, laws, plan, seed, noise, steps)[0]


def simulate_all(
    robot: Robot,
    laws: Sequence[Hidden],
    plan: Plan,
    seed: int,
    noise: Noise = Noise(),
    steps: int = STEPS,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """As `simulate`, and the hidden laws' true forces per coordinate at the samples."""
    excitation, chance, sensors = (np.random.default_rng([seed, i]) for i in range(3))
    machine = Machine(build(robot, laws))
    numbers, control = machine.arm.numbers, robot.controller
    for h in laws:
        for name, (low, high) in LAWS[h.law].per_log.items():
            numbers[f"joint{h.joint}.{h.law}.{name}"] = chance.uniform(low, high)
        if "on" in h.constants:
            numbers[f"joint{h.joint}.{h.law}.on"] = float(plan.payload)
    if control is None:
        raise ValueError(f"robot {robot.name} has no [controller]")
    lead = round(plan.lead / control.period)
    time = (np.arange(round(plan.duration / control.period) + 1 + lead) - lead) * control.period
    reference, feedforward = inputs(robot, plan, time, excitation)
    loop = _Loop(machine, np.array(list(numbers.values())), laws, steps)
    noises = sensors.normal(size=(len(time), len(robot.coordinates) + 3))
    sigma = [noise.e] * len(robot.joints) + [noise.eps] * (len(robot.coordinates) - len(robot.joints))
    measured = loop.run(time, reference, feedforward, noises * np.array([*sigma, *[noise.tip] * 3]))
    joints = [joint_name(k) for k, _ in robot.numbered]
    names = [*robot.coordinates, "tip.x", "tip.y", "tip.z", *(f"{j}.tau" for j in joints)]
    names += [f"{j}.r" for j in joints] + [f"{j}.tau_ff" for j in joints]
    columns = np.column_stack([measured.sensors, measured.command, reference, feedforward])
    frame = pd.DataFrame(columns[lead:], columns=names)
    frame.insert(0, "time", time[lead:])
    forces = pd.DataFrame(measured.hidden[lead:], columns=machine.arm.names)
    return frame, forces


def inputs(robot: Robot, plan: Plan, time: np.ndarray, rng: np.random.Generator) -> tuple:
    """Reference [rad] and feed-forward torque [N m], (N, joints) each."""
    if plan.pace:
        reference = points(plan, time, rng)
        return reference, np.zeros_like(reference)
    reference = np.zeros((len(time), len(robot.joints)))
    torque = np.zeros_like(reference)
    lines = np.linspace(plan.lowest, plan.highest, plan.lines)
    turn = np.exp(2j * np.pi * np.outer(time, lines))
    for k, _ in enumerate(robot.joints):
        running = np.maximum(time, 0)
        swing = plan.swing[k] / 2 * (1 - np.cos(2 * np.pi * running / plan.period[k]))
        drift = time.copy()
        if plan.lead:  # from rest at -lead to full speed at -lead / 2
            ramp = np.minimum((time + plan.lead) / (plan.lead / 2), 1)
            drift = (np.concatenate([[0], np.cumsum(3 * ramp**2 - 2 * ramp**3)[:-1]])) * (time[1] - time[0])
        reference[:, k] = plan.start[k] + plan.drift[k] * drift + swing
        phases = np.exp(1j * rng.uniform(0, 2 * np.pi, plan.lines))
        torque[:, k] = plan.rms[k] * np.sqrt(2 / plan.lines) * np.imag(turn @ phases)
    return reference, torque


def points(plan: Plan, time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(N, joints) [rad]: from rest to rest between random points as a robot works, all joints at once."""
    span, period = np.abs(plan.swing), time[1] - time[0]
    here = np.array(plan.start)
    parts = [np.repeat(here[None], 1 + round((0.2 + plan.lead) / period), axis=0)]
    while sum(map(len, parts)) < len(time):
        there = np.array(plan.start) + rng.uniform(-0.5, 0.5, len(span)) * span
        seconds = max(0.4, float(np.abs(there - here).max()) / plan.pace * 15 / 8)
        s = np.linspace(0, 1, round(seconds / period))[:, None]
        dwell = np.repeat(there[None], round(rng.uniform(0.1, 0.8) / period), axis=0)
        parts += [here + (there - here) * s**3 * (10 - 15 * s + 6 * s**2), dwell]
        here = there
    return np.concatenate(parts)[: len(time)]


@dataclass
class _Measured:
    sensors: np.ndarray
    command: np.ndarray
    hidden: np.ndarray


class _Loop:
    """Sampled PID, amplifier and sensors around a machine."""

    def __init__(self, machine: Machine, p: np.ndarray, laws: Sequence[Hidden], steps: int):
        self.machine, self.p, self.steps = machine, p, steps
        self.joints, control = machine.arm.joints, machine.arm.robot.controller
        assert control is not None
        self.period = control.period
        self.Kp, self.Kd, self.Ki = (np.array(g) for g in (control.Kp, control.Kd, control.Ki))
        self.late = np.zeros(self.joints, dtype=int)
        self.amplifiers, self.encoders = [], []
        for h in laws:
            if h.law == "torque_delay":
                self.late[h.joint - 1] = round(h.constants["samples"] * steps)
            if h.law == "torque_saturation":
                self.amplifiers.append((h.joint - 1, h.constants["limit"], bool(h.constants["soft"])))
            if h.law == "encoder_eccentricity":
                self.encoders.append((h.joint - 1, *(h.constants[n] for n in ("size", "teeth", "phase"))))

    def run(self, time, reference, feedforward, noise) -> _Measured:
        n = len(self.machine.arm.robot.coordinates)
        x, held = self.machine.equilibrium(reference[0], self.p)
        states, commands = np.zeros((len(time), len(x))), np.zeros_like(reference)
        acting, sensors = np.zeros_like(reference), np.zeros((len(time), n + 3))
        line = np.tile(held, (4 * self.steps, 1))  # torques on their way, one per step
        integral, before, h = held.copy(), None, self.period / self.steps
        for i, t in enumerate(time):
            states[i] = x
            sensors[i, :n] = x[:n] + noise[i, :n]
            self._distort(x, sensors[i])
            error = reference[i] - sensors[i, : self.joints]
            integral = integral + self.Ki * self.period * error
            rate = 0 if before is None else (error - before) / self.period
            commands[i] = self.Kp * error + self.Kd * rate + integral + feedforward[i]
            before = error
            u, line = self._travel(line, self._amplified(commands[i]))
            acting[i] = u[0]
            self.machine.advance(float(t), h, x, u, self.p)
            if not np.isfinite(x).all():
                raise UnstableLoop(f"the loop is unstable at {t:.3f} s")
        tips = np.array(self.machine.tip.map(len(time))(states.T, np.tile(self.p, (len(time), 1)).T)).T
        sensors[:, n:] = tips + noise[:, n:]
        hidden = self.machine.hidden.map(len(time))(
            states.T, acting.T, time, np.tile(self.p, (len(time), 1)).T
        )
        return _Measured(sensors, commands, np.array(hidden).T)

    def _distort(self, x: np.ndarray, sensors: np.ndarray) -> None:
        for i, size, teeth, phase in self.encoders:
            sensors[i] += size * np.sin(teeth * x[i] + phase)

    def _amplified(self, command: np.ndarray) -> np.ndarray:
        out = command.copy()
        for i, limit, soft in self.amplifiers:
            rounded = out[i] / (1 + abs(out[i] / limit) ** 8) ** 0.125
            out[i] = rounded if soft else np.clip(out[i], -limit, limit)
        return out

    def _travel(self, line: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Torques of the coming steps, and the torques still on their way after them."""
        for i, late in enumerate(self.late):
            line[late:, i] = torque[i]
        coming = np.ascontiguousarray(line[: self.steps])
        return coming, np.concatenate([line[self.steps :], line[-self.steps :]])


def reference_levels(robot: Robot) -> Levels:
    """What the plain robot shows in its own experiment, free of noise."""
    log = simulate(robot, [], standard(robot, duration=8.2), seed=0, noise=NOISELESS)
    ks = [k for k, _ in robot.numbered]
    torque = np.array([log[torque_of(k)].to_numpy() for k in ks])
    speed = np.array([np.gradient(log[motor_of(k)], log["time"]) for k in ks])
    twist = np.array([log[deformation_of(k)].to_numpy() for k in ks])
    rms = [np.sqrt((a**2).mean(axis=1)) for a in (torque, speed, twist)]
    stiff = np.array([robot.parameters[of_joint(k, "k[1]")] for k in ks])
    return Levels(rms[0], rms[2] * stiff, np.abs(torque).max(axis=1), rms[1], rms[2], robot.parameters)
