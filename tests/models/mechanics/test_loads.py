"""Friction of the load behind rigid joints: Pinocchio's balance of forces, and a lift in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from pinocchio_model import PinocchioRobot, mixed_robot, random_motion, tree_robot

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment
from flexmodels.joint import Joint
from flexmodels.link import Link
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot
from flexmodels.settings.controller import Controller

LINEAR, SQUARE = 0.3, 1e-3
G, MASS, ROTOR, COULOMB, SHARE, SPRING, PERIOD = 9.81, 20.0, 5.0, 30.0, 0.2, 4000.0, 0.01


def loaded(robot):
    """With friction of the load at every rigid joint."""
    laws = {
        "load_dependent_friction": {"coefficient": LINEAR},
        "quadratic_load_friction": {"growth": SQUARE},
    }
    joints = (j if j.flexible else replace(j, values={**j.values, **laws}) for j in robot.joints)
    return replace(robot, joints=tuple(joints))


ROBOTS = [loaded(mixed_robot()), loaded(tree_robot(seed=1)), loaded(tree_robot(seed=0, passive=2))]


def taken(robot, load, mode, speed):
    """The frictions' sum at each motor and the size of the dry part, of values told apart from the laws."""
    values = [joint.values for joint in robot.joints]
    coulomb = np.array([v["coulomb"]["coulomb"] for v in values])
    viscous = np.array([v["viscous"]["viscous"] for v in values])
    rigid = np.array([not joint.flexible for joint in robot.joints])
    dry = coulomb + rigid * (LINEAR * np.abs(load) + SQUARE * load**2)
    return mode * dry + viscous * speed, dry


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
@pytest.mark.parametrize("stuck", [(), (1,), (1, 3)])
def test_forces_balance_as_pinocchio_says(robot, stuck):
    eq, oracle, n, joints = equations(robot), PinocchioRobot(robot), len(robot.coordinates), 5
    p, rng = np.array(list(eq.parameters.values())), np.random.default_rng(4)
    inertia = np.array([joint.values["motor_inertia"]["J_m"] for joint in robot.joints])
    for q, v, _ in zip(*random_motion(robot, 20, seed=6), strict=True):
        mode = rng.choice([-1.0, 1.0], joints)
        mode[list(stuck)] = v[list(stuck)] = 0.0
        u, x = rng.normal(0, 60, joints), np.r_[q, v]
        dx, imbalance, friction = (np.array(out).ravel() for out in eq.rates(x, u, p, mode))
        a = dx[n:]
        links = oracle.inverse_dynamics(q, v, a)
        expected, dry = taken(robot, links[:joints], mode, v[:joints])
        np.testing.assert_allclose(friction, expected, atol=1e-7)
        left = u - inertia * a[:joints] - expected - links[:joints]
        assert (a[list(stuck)] == 0).all()
        np.testing.assert_allclose(left, np.where(mode == 0, left, 0.0), atol=1e-7)
        np.testing.assert_allclose(imbalance[list(stuck)], left[list(stuck)], atol=1e-7)
        upper, lower = (np.array(out).ravel() for out in eq.breakaway(x, u, p, mode))
        np.testing.assert_allclose(upper, dry, atol=1e-7)
        np.testing.assert_allclose(lower, -dry, atol=1e-7)


def lift() -> Robot:
    """A carriage that rises along z behind the spring of its controller."""
    laws = {
        "motor_inertia": {"J_m": ROTOR},
        "coulomb": {"coulomb": COULOMB},
        "viscous": {"viscous": 0.0},
        "load_dependent_friction": {"coefficient": SHARE},
    }
    joint = Joint("prismatic", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0), False, laws)
    return Robot(
        "lift",
        (joint,),
        (Link(MASS, (0.0, 0.0, 0.0), (0.0,) * 6),),
        tip=(0.0, 0.0, 1.0),
        gravity=(0.0, 0.0, -G),
        controller=Controller(1 / PERIOD, (SPRING,), (0.0,), (0.0,)),
    )


def event_exact(torques):
    """The carriage under forces that are held, parabola by parabola: positions, number of sticks."""
    weight, x, v, mode, sticks, out = MASS * G, 0.0, 0.0, 0, 0, [0.0]
    for force in torques[:-1]:
        left = PERIOD
        while left > 0:
            if mode == 0 and abs(force - weight) <= COULOMB + SHARE * weight:
                break
            if mode == 0:
                mode = 1 if force > weight else -1
            grown = MASS * (1 + mode * SHARE)  # the load never changes its sign here: m (a + g) > 0
            a = (force - mode * COULOMB - grown * G) / (grown + ROTOR)
            assert a > -G
            stop = -v / a if a * v < 0 else np.inf
            h = min(left, stop)
            x, v, left = x + v * h + a * h * h / 2, v + a * h, left - h
            if h == stop:
                v, mode, sticks = 0.0, 0, sticks + 1
        out.append(x)
    return np.array(out), sticks


def test_a_lift_sticks_and_breaks_away_as_the_closed_form_says(tmp_path):
    time = np.arange(301) * PERIOD
    pull = np.where(time < 1.0, 0.08 * time, 0.08 - 0.1 * (time - 1.0))
    path = export_fmu(equations(lift()), tmp_path / "lift.fmu")
    with LoadedFmu(path) as fmu:
        log = fmu.simulate(Experiment(time, pull[:, None], 0 * time[:, None]))
    position, sticks = event_exact(log["joint1.tau"].to_numpy())
    assert sticks >= 2
    assert np.ptp(position) > 0.05
    np.testing.assert_allclose(log["joint1.e"], position, atol=1e-11)
