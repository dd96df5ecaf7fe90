"""Logs of motors whose drives bend, by flatness: links follow a plan, motors lead them by what they carry.

A machine whose links move as q(t) asks for loads F(q, q̇, q̈). A drive of compliance c carries F and bends by
c F, so that its motor is at q + c F (Spong 1987): no spring has to be integrated.
"""

import numpy as np
from scipy.interpolate import CubicSpline

from ..foreign_logs.cases import RATES, SIZES, Case
from ..foreign_logs.generator import Made, NotDrawn, Truth, first_drawn, hidden_in
from ..foreign_logs.laws import SINGLE, State
from ..foreign_logs.machines import drawn_machine, owners_file
from ..foreign_logs.motions import Course, drawn_plan
from ..foreign_logs.oracle import Oracle
from ..foreign_logs.sensors import drawn_sensors, noise_of, recorded, rounded, with_columns
from ..rigid_arm.pinocchio_chain import pinocchio

EVERY = "every drive"
KINDS = ("null", "strong", "medium", "pair", "law", EVERY)
DRIVE = "drive_compliance"
MOST_SAMPLES = 4000
_DRIVES = {"strong": 1, "medium": 1, "pair": 2, "law": 1}
_SIZES = {"medium": SIZES["medium"], EVERY: (SIZES["medium"][0], SIZES["strong"][1])}
_FINER = 8  # steps to a sample, along which loads are differentiated
_BENDS = 0.03  # rad, at most: no drive gives way further
_SWINGS = 4.0  # Hz, at least, at which a link swings on its drive: plans end at 1 Hz
_STEP = 1e-6  # rad
_POSES = 50
_MACHINES = 1000  # few have two drives that bend that far


def case_list(seed: int, count: int) -> list[Case]:
    """The first `count` cases of a seed; more cases begin with the same ones."""
    return [_case(seed, i) for i in range(count)]


def _case(seed: int, number: int) -> Case:
    rng = np.random.default_rng([seed, number])
    kind, rate = KINDS[number % len(KINDS)], int(rng.choice(RATES[:-1]))
    duration = round(float(min(rng.uniform(20, 40), MOST_SAMPLES / rate)), 1)
    return Case(f"{number + 1:03d}", (seed, number), kind, False, False, rate, duration, False, False)


def made(case: Case) -> Made:
    """Draws until a machine has drives that can bend as far as the kind of the case asks for."""
    rng = case.rng
    return first_drawn(case, lambda: _made(case, rng), _MACHINES)


def _made(case: Case, rng: np.random.Generator) -> Made:
    machine = drawn_machine(rng)
    oracle, sensors = Oracle(machine), drawn_sensors(rng, False, 1 / case.rate)
    plans = [drawn_plan(rng, machine.sliders, case.duration, False, False) for _ in range(2)]
    rigid = at_motors(oracle, plans[0], np.zeros(len(machine.rotor)), case.rate, case.duration)
    level = np.sqrt(np.mean(np.square(oracle.plain(*rigid)), axis=0))
    noise = noise_of(sensors, level)
    drives = _drives(rng, case.kind, oracle, *rigid, noise)
    compliance = np.zeros(len(machine.rotor))
    for t in drives:
        compliance[t.names[0][1] - 1] = t.amount
    truth, hidden = drives, []
    if case.kind == "law":
        bent = [t.names[0][1] - 1 for t in drives]
        draw = SINGLE[str(rng.choice(list(SINGLE)))]
        law, found = hidden_in(rng, draw, "strong", oracle, *rigid, noise, bent)
        truth, hidden = [*truth, found], [law]
    frames = []
    for plan, duration in zip(plans, (case.duration, max(case.duration / 2, 8.0)), strict=True):
        state, a = at_motors(oracle, plan, compliance, case.rate, duration)
        tau = oracle.plain(state, a)
        for h in hidden:
            tau[:, h.joint] += h.amplitude * h.law.torque(state, h.joint)
        q = rounded(state.q, sensors, machine.sliders)
        frames.append(recorded(state.time, q, tau, level, sensors, rng))
    robot = with_columns(owners_file(machine, rng, ()), sensors)
    return Made(robot, frames[0], frames[1], tuple(truth))


def at_motors(
    oracle: Oracle, plan: Course, compliance: np.ndarray, rate: float, duration: float
) -> tuple[State, np.ndarray]:
    """The motors' motion, with the loads that their drives carry, and their accelerations (N, n).

    plan   of the links;  compliance (n,) [rad/(N m)];  rate [Hz], duration [s] of the log
    """
    fine = np.arange(0, duration, 1 / (rate * _FINER))
    q, v, a = plan.at(fine)
    load = oracle.state(fine, q, v, a).load
    bend = CubicSpline(fine, compliance * load)
    time, every = fine[::_FINER], slice(None, None, _FINER)
    motor = [own[every] + bend(time, order) for order, own in enumerate((q, v, a))]
    return State(time, motor[0], motor[1], load[every]), motor[2]


def _drives(
    rng: np.random.Generator, kind: str, oracle: Oracle, state: State, a: np.ndarray, noise: np.ndarray
) -> list[Truth]:
    """Drives that bend, as far as the kind of a case asks for. Raises NotDrawn."""
    hinges = np.flatnonzero(~oracle.machine.sliders)
    order = [int(k) for k in rng.permutation(hinges)]
    wanted = len(order) if kind == EVERY else _DRIVES.get(kind, 0)
    found: list[Truth] = []
    for k in order:
        if len(found) == wanted:
            break
        size = float(rng.uniform(*_SIZES.get(kind, SIZES["strong"])))
        compliance = size / _size(oracle, state, a, k, noise)
        if compliance <= _softest(oracle, state, k):
            found.append(Truth(DRIVE, ((DRIVE, k + 1),), size, compliance))
    few = 2 if kind == EVERY else wanted
    if len(found) < few or (kind == "law" and a.shape[1] < 2):
        raise NotDrawn
    return found


def _size(oracle: Oracle, state: State, a: np.ndarray, k: int, noise: np.ndarray) -> float:
    """What bodies and usual frictions cannot imitate of a drive's bend, over the noise of the joint that it
    shows best at; per unit of its compliance.
    """
    load = CubicSpline(state.time, state.load[:, k])
    step = _STEP / max(float(np.abs(state.load[:, k]).max()), 1e-9)
    links = [x.copy() for x in (state.q, state.v, a)]
    for order, own in enumerate(links):
        own[:, k] -= step * load(state.time, order)
    slope = (oracle.state(state.time, *links).load - state.load) / step
    left = oracle.beyond(state, a, slope)
    return max(float((np.sqrt(np.mean(left**2, axis=0)) / noise).max()), 1e-9)


def _softest(oracle: Oracle, state: State, k: int) -> float:
    """The largest compliance [rad/(N m)] at which a drive hardly gives way and its link does not swing."""
    pin, data = pinocchio(), oracle.model.createData()
    poses = state.q[:: max(1, len(state.q) // _POSES)]
    inertia = max(float(pin.crba(oracle.model, data, q)[k, k]) for q in poses)
    bends = _BENDS / max(float(np.abs(state.load[:, k]).max()), 1e-9)
    return min(bends, 1 / (inertia * (2 * np.pi * _SWINGS) ** 2))
