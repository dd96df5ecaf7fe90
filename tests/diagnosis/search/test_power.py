"""Friction takes power: a law that would drive its joint is refused, however well it fits."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from six_axis_logs import COULOMB, VISCOUS, arm, made, plain

from pyident.conditioning.motion import Motion
from pyident.conditioning.weak_form import condition
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.search.gate import admission
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.power import energy_below_zero, energy_put_in
from pyident.diagnosis.searched import searched
from pyident.kinematics.transfer import tip_positions
from pyident.regression.spectrum import equations

LAW = Candidate("asymmetric_coulomb", 1)


def never(_):
    raise AssertionError("nothing is simulated where the loop is unknown")


def asymmetric(more: float):
    """Slopes of the two directions of joint 1 differ by twice `more` times its own friction at 1 rad/s."""

    def friction(q, v, load, time):
        out = plain(q, v, load, time)
        out[:, 0] += more * (COULOMB[0] + VISCOUS[0]) * np.abs(v[:, 0])
        return out

    return friction


@pytest.mark.parametrize("more", [0.5, 4.0])
def test_energy_that_friction_puts_in_is_that_of_the_closed_form(more):
    robot = arm()
    log = made(robot, 0, plain, 20.0)
    (data,) = equations(robot, [condition(log, robot)], [log.period])
    named = {
        f"joint{k + 1}.{name}": x[k]
        for k in range(6)
        for name, x in (("coulomb", COULOMB), ("viscous", VISCOUS))
    }
    p = np.array([named.get(name, 0.0) for name in robot.linear_parameters])
    law = (LAW, np.array([more * COULOMB[0], 0.0]))
    v = data.part.motion.dq[:, 0]
    power = (COULOMB[0] * np.sign(v) + VISCOUS[0] * v + more * COULOMB[0]) * v * data.part.use[:, 0]
    expected = -power[power < 0].sum() / power[power > 0].sum()
    assert energy_put_in(robot, [data], p, [law], 1) == pytest.approx(expected, rel=1e-9)
    assert (expected == 0) == (more < 1)
    assert energy_put_in(robot, [data], p, [law], 2) == 0  # of another joint


@pytest.mark.slow
def test_a_difference_of_directions_is_named_until_it_would_drive():
    robot, said = arm(), {}
    for more in (0.5, 4.0):
        logs = [made(robot, seed, asymmetric(more), 20.0) for seed in range(2)]
        search = searched(robot, logs, never)
        found = search.best(LAW.effect, LAW.joint)
        assert found is not None
        said[more] = admission(search, found, [found.candidate], HeldOut(())).reason
        ranked = next(f for f in search.step().ranked if f.candidate.family == LAW.family)
        assert (ranked.excess > 0) == (more < 1)
    assert said[0.5] == ""
    assert "would drive it" in said[4.0]


def test_a_body_has_the_energy_of_its_tip_and_its_turn():
    """A point mass at the tip less a ball's inertia, in random poses that turn about the first axis."""
    robot, rng = arm(), np.random.default_rng(3)
    q, dq = rng.uniform(-2, 2, (200, 6)), np.zeros((200, 6))
    dq[:, 0] = rng.uniform(-2, 2, 200)
    step = 1e-6
    speed = np.linalg.norm(tip_positions(robot, q + step * dq) - tip_positions(robot, q - step * dq), axis=1)
    energy = 0.5 * 2.0 * (speed / (2 * step)) ** 2 - 0.5 * 0.02 * dq[:, 0] ** 2
    expected = -energy[energy < 0].sum() / energy[energy > 0].sum()
    assert 0.01 < expected < 0.5
    log: Any = SimpleNamespace(part=SimpleNamespace(motion=Motion(q, dq, np.zeros_like(q))))
    body = np.array([2.0, 0, 0, 0, -0.02, 0, 0, -0.02, 0, -0.02])
    payload = Candidate("payload", 6)
    assert energy_below_zero(robot, [log], payload, body) == pytest.approx(expected, rel=1e-6)
    assert energy_below_zero(robot, [log], replace(payload, log=1), body) == 0  # in another log


def test_a_load_is_in_the_log_that_has_it():
    """What is missing in one log is in the other: a body of negative mass would do as well in the first."""
    robot = arm()
    heavier = robot.with_parameters({"link6.m": robot.parameters["link6.m"] + 1.5})
    logs = [made(machine, seed, plain, 20.0) for seed, machine in enumerate((robot, heavier))]
    search = searched(robot, logs, never)
    best = search.step().best
    assert best.candidate == Candidate("payload", 6, log=1)
    assert best.gain.coefficients[0] == pytest.approx(1.5, abs=0.1)
    assert search.drives([best.candidate]) < 0.1 < search.drives([replace(best.candidate, log=0)])
