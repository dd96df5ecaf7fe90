"""A machine that changes in the midst of a log is told with its instant; one that the model lacks is not.

Six axes by Pinocchio, on sines of every joint; at will slow first and fast then.
"""

import re
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest
from studies.log_checks.swings import six_axes
from studies.rigid_arm.pinocchio_chain import chain, inverse_dynamics, pinocchio

from flexmodels.files.robot_file import load_robot
from pyident.checks.balances import balances, samples
from pyident.checks.changes import _both_ways, changes, last_body, one_machine
from pyident.checks.check_log import check_log, checked
from pyident.checks.defect import Defect
from pyident.logs.log import Log

ARM = six_axes()
MOTORS = np.array([0.4, 0.6, 0.3, 0.06, 0.05, 0.03])  # kg m^2
T, N = 0.005, 2400
TIME = T * np.arange(N)
EVEN = np.ones(N)
SLOW_THEN_FAST = 0.35 + 1.05 / (1 + np.exp(-2.2 * (TIME - 6.0)))  # the path's rate


@dataclass(frozen=True)
class Machine:
    """q, dq, ddq, tau (N, 6) without noise; level (6,) torques' rms, x (N, 6) speeds over their rms."""

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    tau: np.ndarray
    level: np.ndarray
    x: np.ndarray

    def load(self, mass: float) -> np.ndarray:
        """(N, 6) torques of a load [kg] beside the flange."""
        pin, heavier = pinocchio(), chain(ARM)
        lever, ball = np.array([0.04, -0.03, 0.08]), 2e-3 * mass * np.eye(3)
        heavier.inertias[6] = heavier.inertias[6] + pin.Inertia(mass, lever, ball)
        moved = self.q, self.dq, self.ddq
        return inverse_dynamics(heavier, *moved) - inverse_dynamics(chain(ARM), *moved)

    def log(self, extra: np.ndarray, bend: np.ndarray | float = 0.0) -> Log:
        """With further torques, bends of the drives [rad], and 0.5 % of noise."""
        rng, frame = np.random.default_rng(8), {"time": TIME}
        motor, tau = self.q + bend, self.tau + extra
        for k in range(6):
            frame[f"joint{k + 1}.e"] = motor[:, k] + rng.normal(0, 2e-6, N)
            frame[f"joint{k + 1}.tau"] = tau[:, k] + rng.normal(0, 5e-3 * self.level[k], N)
        return Log(pd.DataFrame(frame), "a log")


def machine(rate: np.ndarray = EVEN, seed: int = 3) -> Machine:
    """Along sines that are gone through at a rate (N,)."""
    rng, phase = np.random.default_rng(seed), np.cumsum(rate) * T
    waves = rng.uniform(0.1, 0.8, (5, 6)), rng.uniform(0, 2 * np.pi, (5, 6)), rng.uniform(0.5, 1, (5, 6))
    w, start, size = (x[:, None] for x in waves)
    q = (size / w * np.sin(2 * np.pi * w * phase[:, None] + start)).sum(axis=0)
    q *= 0.6 / np.gradient(q, T, axis=0).std(axis=0)
    dq = np.gradient(q, T, axis=0, edge_order=2)
    ddq = np.gradient(dq, T, axis=0, edge_order=2)
    tau = inverse_dynamics(chain(ARM, rng.uniform(0.8, 1.2, 6)), q, dq, ddq)
    tau += MOTORS * ddq
    level, x = tau.std(axis=0), dq / dq.std(axis=0)
    return Machine(q, dq, ddq, tau + level * (0.08 * np.tanh(dq / 1e-3) + 0.05 * x), level, x)


def told(log: Log) -> list[Defect]:
    signals = samples(ARM, log)
    assert signals is not None
    return list(changes(balances(signals), log))


def since(at: float) -> np.ndarray:
    return (at <= TIME)[:, None]


@pytest.mark.parametrize("rate", [EVEN, SLOW_THEN_FAST], ids=["even", "slow then fast"])
@pytest.mark.parametrize(("mass", "at"), [(0.1, 8.2), (0.5, 4.3), (-0.1, 5.0)])
def test_a_load_is_told_with_its_instant_and_its_mass(rate, mass, at):
    of = machine(rate)
    extra = of.load(abs(mass))
    (defect,) = told(of.log(extra * (since(at) if mass > 0 else ~since(at))))
    assert (defect.severity, defect.channel) == ("doubtful", "")
    assert "The last link has another body" in defect.sentence
    instant, size, way = re.findall(r"from (\S+) s .*\((\S+) kg (more|less)\)", defect.sentence)[0]
    assert float(instant) == pytest.approx(at, abs=0.03)
    assert float(size) == pytest.approx(abs(mass), rel=0.2)
    assert way == ("more" if mass > 0 else "less")


@pytest.mark.parametrize("k", [1, 2, 5])
def test_a_brake_that_drags_is_told_at_its_joint(k):
    of = machine()
    drag = np.zeros((N, 6))
    drag[:, k - 1] = 0.1 * of.level[k - 1] * np.sign(of.dq[:, k - 1])
    (defect,) = told(of.log(drag * since(6.4)))
    assert defect.channel == f"joint{k}.tau"
    instant, size = re.findall(r"from (\S+) s .*\((\S+) N m more\)", defect.sentence)[0]
    assert float(instant) == pytest.approx(6.4, abs=0.1)
    assert float(size) == pytest.approx(0.1 * of.level[k - 1], rel=0.2)


LACKING = {
    "nothing": lambda m: 0.0,
    "friction that falls with the speed": lambda m: 0.1 * np.exp(-((m.x / 0.3) ** 2)) * np.sign(m.x),
    "friction by the square of the speed": lambda m: 0.1 * m.x * np.abs(m.x),
    "friction under load": lambda m: 0.15 * np.abs(m.tau) / m.level * np.sign(m.x),
    "friction that grows": lambda m: 0.05 * np.sign(m.x) * TIME[:, None] / TIME[-1],
    "friction that warms up": lambda m: 0.08 * np.sign(m.x) * np.exp(-TIME / 2.0)[:, None],
    "a ripple": lambda m: 0.04 * np.sin(24 * m.q),
    "a load that grows": lambda m: m.load(0.5) * TIME[:, None] / TIME[-1] / m.level,
}


@pytest.mark.parametrize("rate", [EVEN, SLOW_THEN_FAST], ids=["even", "slow then fast"])
@pytest.mark.parametrize("lacks", LACKING)
def test_what_the_model_lacks_is_no_change(lacks, rate):
    of = machine(rate)
    assert told(of.log(of.level * LACKING[lacks](of))) == []


@pytest.mark.parametrize("rate", [EVEN, SLOW_THEN_FAST], ids=["even", "slow then fast"])
def test_drives_that_bend_are_no_change(rate):
    of = machine(rate)
    assert told(of.log(np.zeros((N, 6)), 2e-3 * of.tau / of.level)) == []


def test_a_load_is_told_beside_friction_that_the_model_lacks():
    of = machine(SLOW_THEN_FAST)
    friction = of.level * LACKING["friction that falls with the speed"](of)
    (defect,) = told(of.log(friction + of.load(0.3) * since(8.0)))
    assert "from 8 s" in defect.sentence


def test_the_clock_is_the_logs_own():
    of = machine()
    log = of.log(of.load(0.5) * since(8.0))
    late = Log(log.frame.assign(time=TIME + 1000.0), "a log")
    (defect,) = [d for d in check_log(ARM, late) if d.kind == "change"]
    assert "from 1008 s on" in defect.sentence


def test_of_a_short_log_and_of_a_loops_last_link_nothing_is_asked():
    signals = samples(ARM, Log(machine().log(np.zeros((N, 6))).frame.head(150), "short"))
    assert signals is not None
    assert one_machine(balances(signals)) is None
    loop, wave = load_robot("parallelogram"), np.sin(np.outer(TIME, np.arange(1.1, 12)))
    names = [*loop.coordinates, *loop.torques]
    frame = {name: 0.1 * wave[:, i] for i, name in enumerate(names)}
    signals = samples(loop, Log(pd.DataFrame({"time": TIME} | frame), "loop"))
    assert signals is not None
    of = balances(signals)
    one = one_machine(of)
    assert one is not None
    assert last_body(of, one) is None


def test_friction_of_one_way_alone_says_nothing_of_a_change():
    own = samples(ARM, machine().log(np.zeros((N, 6))))
    assert own is not None
    of, middle = balances(own), len(own.at) // 2
    assert all(_both_ways(of, k, middle) for k in of.joints)
    for part in (slice(None, middle), slice(middle, None)):
        dq = own.dq.copy()
        dq[part] = np.abs(dq[part])
        assert not any(_both_ways(replace(of, samples=replace(own, dq=dq)), k, middle) for k in of.joints)


def test_a_joint_that_carries_nothing_but_rounding_does_not_count():
    of = machine()
    log = of.log(of.load(0.3) * since(8.0))
    rounding = 1e-18 * np.random.default_rng(1).standard_normal(N)
    bare = Log(log.frame.assign(**{"joint6.tau": rounding}), "a log")
    (defect,) = told(bare)
    assert "from 8 s" in defect.sentence


@pytest.mark.parametrize("mass", [0.1, -0.5])
def test_a_load_in_one_log_of_two_is_told_with_its_mass(mass):
    """Beside another motion and another friction."""
    slow, even = machine(SLOW_THEN_FAST), machine()
    first, second = (of.log(of.load(abs(mass)) * own) for of, own in ((slow, mass < 0), (even, mass > 0)))
    (defect,) = checked(ARM, [first, replace(second, source="another")]).defects
    assert (defect.kind, defect.severity) == ("change", "doubtful")
    size, way = re.findall(r"another: the last link has another body than in a log \((\S+) kg (\w+)\)",
                           defect.sentence)[0]  # fmt: skip
    assert float(size) == pytest.approx(abs(mass), rel=0.1)
    assert way == ("more" if mass > 0 else "less")


@pytest.mark.slow
@pytest.mark.parametrize("law", sorted(LACKING.keys() - {"a load that grows"}))
def test_what_both_logs_lack_is_no_load(law):
    logs = [of.log(of.level * LACKING[law](of)) for of in (machine(SLOW_THEN_FAST), machine())]
    assert "change" not in {defect.kind for defect in checked(ARM, logs).defects}
