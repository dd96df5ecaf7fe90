"""The logs of a case, its owner's robot file, and what is hidden."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from flexmodels.robot import Robot

from .cases import SIZES, Case, large_error, small_errors
from .closed_loop import STEP, Hidden, loop_noise, simulated, spread_above
from .laws import OUTSIDE, SINGLE, Draw, State
from .machines import Error, Machine, drawn_machine, owners_file
from .motions import Plan, drawn_plan
from .oracle import Oracle
from .sensors import Sensors, drawn_sensors, noise_of, noise_power, recorded, rounded, with_columns

_HIDDEN = {"strong": 1, "medium": 1, "weak": 1, "outside": 1, "pair": 2, "triple": 3}
_DRAWS = 30  # of an error of the geometry, until the logs can show it; then of another machine
_MACHINES = 50
_LOCKS = 2.0  # times its load: friction of that size
_READABLE = 10.0  # standard deviations: from there on the logs tell an error's value within 20 %


@dataclass(frozen=True)
class Truth:
    """What is hidden at a joint (from 1), and which names are right.

    size    rms of what bodies and usual frictions cannot imitate, over the noise of the joint's torque
    amount  of an error of the geometry [m or rad]
    """

    law: str
    names: tuple[tuple[str, int], ...]
    size: float
    amount: float | None = None


@dataclass(frozen=True)
class Made:
    """robot: the owner's file;  fit, heldout: the owner's logs, in his units;  truth: sealed.

    besides   names of what makes a case difficult: true, though nobody asks for them
    """

    robot: Robot
    fit: pd.DataFrame
    heldout: pd.DataFrame
    truth: tuple[Truth, ...]
    besides: tuple[tuple[str, int], ...] = ()

    @property
    def sealed(self) -> dict[str, Any]:
        """What nobody may see before an answer is on the disk, as JSON has it."""
        return {"truth": [asdict(t) for t in self.truth], "besides": self.besides}


def made(case: Case, most: int = 7) -> Made:
    """Draws until a loop holds its machine, and its logs can show an error of its geometry. most: joints."""
    rng = case.rng
    return first_drawn(case, lambda: _made(case, rng, most))


def first_drawn(case: Case, draw: Callable[[], Made], machines: int = _MACHINES) -> Made:
    """The first of some draws that no loop refuses and in which all can be hidden."""
    for _ in range(machines):
        try:
            return draw()
        except (FloatingPointError, NotDrawn):
            continue
    raise RuntimeError(f"case {case.id}: none of {machines} machines will do; take another seed")


class NotDrawn(Exception):
    """A machine hides the errors of its geometry, which its bodies take up; or its friction would lock it."""


def _made(case: Case, rng: np.random.Generator, most: int) -> Made:
    machine = drawn_machine(rng, most)
    n, oracle = len(machine.rotor), Oracle(machine)
    sensors = drawn_sensors(rng, case.difficult, 1 / case.rate)
    plans = [drawn_plan(rng, machine.sliders, case.duration, case.periodic, case.slow) for _ in range(2)]
    time = np.arange(0, case.duration, 1 / case.rate)
    q, v, a = plans[0].at(time)
    state = oracle.state(time, q, v, a)
    level = np.sqrt(np.mean(np.square(oracle.plain(state, a)), axis=0))
    noise = noise_of(sensors, level)
    power = noise_power(sensors, level, len(time), 1 / case.rate)
    if case.closed:
        _, _, torques = _in_loop(case, oracle, plans[0], [], sensors, min(case.duration, 5.0))
        fast = loop_noise(torques, 1 / case.rate)
        noise, power = np.hypot(noise, fast), power + spread_above(fast, len(power), 1 / case.rate)
    errors = small_errors(rng, n) if case.difficult and rng.random() < 0.5 else ()
    truth: list[Truth] = []
    hidden = []
    if case.kind == "geometry":
        error, found = _geometry(rng, oracle, state, a, power)
        errors, truth = (error,), [found]
    for law in laws_of(rng, case.kind):
        h, found = hidden_in(rng, law, case.kind, oracle, state, a, noise, [h.joint for h in hidden])
        hidden.append(h)
        truth.append(found)
    frames = []
    for plan, duration in zip(plans, (case.duration, max(case.duration / 2, 8.0)), strict=True):
        run = _in_loop if case.closed else _along
        frames.append(recorded(*run(case, oracle, plan, hidden, sensors, duration), level, sensors, rng))
    robot = with_columns(owners_file(machine, rng, errors), sensors)
    return Made(robot, frames[0], frames[1], tuple(truth), _besides(sensors, errors, n))


def _besides(sensors: Sensors, errors: Sequence[Error], joints: int) -> tuple[tuple[str, int], ...]:
    late = ["torque_delay", "torque_lag"] if sensors.delay else []  # of torques, against positions
    effects = [*late, "torque_gain"] if sensors.gain != 1 else late
    everywhere = [(name, k + 1) for name in effects for k in range(joints)]
    return (*everywhere, *((e.quantity, e.joint) for e in errors))


def _along(
    case: Case, oracle: Oracle, plan: Plan, hidden: list[Hidden], sensors: Sensors, duration: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """time, encoders, torques along the plan itself."""
    time = np.arange(0, duration, 1 / case.rate)
    q, v, a = plan.at(time)
    state = oracle.state(time, q, v, a)
    tau = oracle.plain(state, a)
    for h in hidden:
        tau[:, h.joint] += h.amplitude * h.law.torque(state, h.joint)
    return time, rounded(plan.at(time - sensors.delay)[0], sensors, oracle.machine.sliders), tau


def _in_loop(
    case: Case, oracle: Oracle, plan: Plan, hidden: list[Hidden], sensors: Sensors, duration: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    every = round(1 / (case.rate * STEP))
    return simulated(oracle.machine, plan, hidden, sensors, duration, every)


def laws_of(rng: np.random.Generator, kind: str) -> list[Draw]:
    if kind not in _HIDDEN:
        return []
    listed = OUTSIDE if kind == "outside" else SINGLE
    return [listed[name] for name in rng.choice(list(listed), _HIDDEN[kind], replace=False)]


def hidden_in(
    rng: np.random.Generator,
    draw: Draw,
    kind: str,
    oracle: Oracle,
    state: State,
    a: np.ndarray,
    noise: np.ndarray,
    taken: list[int],
) -> tuple[Hidden, Truth]:
    """A law at a joint that no other has, if there is one left, as large as its kind asks for.

    Raises NotDrawn where friction would be so much of its load that no gear moves.
    """
    n = len(noise)
    joints = [k for k in range(n) if k not in taken] or list(range(n))
    k = int(rng.choice(joints))
    law = draw(rng, state, k)
    force = np.zeros_like(a)
    force[:, k] = law.torque(state, k)
    left = oracle.beyond(state, a, force)[:, k]
    unit = max(float(np.sqrt(np.mean(left**2))), 1e-3 * float(np.sqrt(np.mean(force**2))))
    size = float(rng.uniform(*SIZES.get(kind, SIZES["strong"])))
    amplitude = size * noise[k] / unit
    if law.name == "load" and amplitude > _LOCKS * float(np.sqrt(np.mean(state.load[:, k] ** 2))):
        raise NotDrawn
    names = tuple((name, k + 1) for name in law.names)
    return Hidden(law, k, amplitude), Truth(law.name, names, size)


def _geometry(
    rng: np.random.Generator, oracle: Oracle, state: State, a: np.ndarray, power: np.ndarray
) -> tuple[Error, Truth]:
    """An error whose value the logs can tell. power: of the noise (frequencies, n). Raises NotDrawn."""
    n = power.shape[1]
    for _ in range(_DRAWS):
        error = large_error(rng, n)
        file = Oracle(_filed(oracle.machine, error))  # all that its owner can fit with
        as_filed = file.state(state.time, state.q, state.v, a)
        force = state.load - as_filed.load
        if file.deviations(as_filed, a, force, power) > _READABLE:
            left = file.beyond(as_filed, a, force)
            size = float((np.sqrt(np.mean(left**2, axis=0) / power.mean(axis=0))).max())
            return error, Truth("geometry", ((error.quantity, error.joint),), size, error.amount)
    raise NotDrawn


def _filed(machine: Machine, error: Error) -> Machine:
    """The machine with the same bodies behind a joint that sits as the file says."""
    robot = owners_file(machine, np.random.default_rng(0), (error,))
    return replace(machine, robot=replace(robot, links=machine.robot.links))
