"""A fit that cannot be simulated, because what the model lacks has bent it, is made one that can be."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from two_link_logs import hidden, loaded, made_log, two_link

import pyident as pi
from flexmodels.experiment import line
from flexmodels.files.robot_file import load_robot
from flexmodels.inputs import SimulationError
from pyident.diagnosis import diagnose, searched
from pyident.diagnosis.another_state import fitted_apart
from pyident.diagnosis.base import floor_shares
from pyident.diagnosis.base.residual_over_floor import examine
from pyident.diagnosis.base.setting import Setting, set_up, steadied, workers_of
from pyident.diagnosis.rounds import laws_that_follow
from pyident.rules.rules import RULES
from pyident.simulation.fmu_runs import fmu_here, runs_here


def test_a_hinge_without_spring_gets_a_tenth_of_its_middle_one_and_damping_with_it():
    robot = load_robot("four_link")
    before = robot.parameters
    soft = robot.with_parameters({"joint4.k[1]": 1e-8, "joint4.d[1]": 0.0})
    none: Any = None
    setting = steadied(Setting(soft, soft, (), {}, none, none))
    values = setting.simulated.parameters
    middle = np.median([1e-8, before["joint4.k[2]"], before["joint4.k[3]"]])
    assert values["joint4.k[1]"] == pytest.approx(0.1 * middle)
    assert values["joint4.d[1]"] > 0
    others = [n for n in before if ".k[" in n and n != "joint4.k[1]"]
    assert {n: values[n] for n in others} == {n: before[n] for n in others}
    motion = line(robot)
    with fmu_here(robot) as fmu:
        with pytest.raises(SimulationError, match="equilibrium"):
            fmu.simulate(motion, soft.parameters)
        assert len(fmu.simulate(motion, values | dict(setting.solver)))


def test_a_rotor_that_no_loop_holds_and_a_damping_that_no_step_follows_are_made_usual():
    """Kd T is 1.53 kg m2 at joint 3; a damping stays within ten times that of the hinge in the middle."""
    robot = load_robot("four_link")
    before, none = robot.parameters, cast(Any, None)
    bent = robot.with_parameters({"joint3.J_m": 1e-7, "joint3.d[2]": 1e5})
    values = steadied(Setting(bent, bent, (), {}, none, none)).simulated.parameters
    assert values["joint3.J_m"] == pytest.approx(381.7 * 0.004)
    ratios = [values[d] / values[d.replace(".d[", ".k[")] for d in values if ".d[" in d]
    assert max(ratios) == pytest.approx(10 * min(ratios))
    others = [n for n in before if n.endswith("J_m") and not n.startswith("joint3")]
    assert {n: values[n] for n in others} == {n: before[n] for n in others}


@pytest.mark.parametrize(
    ("motors", "used", "little"),
    [
        ((0.3, 0.4, 0.3, 0.02), 4, True),
        ((0.3, 0.1, 0.1, 0.02), 4, False),
        ((0.1, 0.1, 0.9, 0.9), 2, False),  # two stand still
        ((0.9, 0.9, 0.9, 0.9), 0, False),
    ],
)
def test_replicas_that_leave_most_motors_much_of_their_torque_are_worth_little(
    motors, used, little, monkeypatch
):
    """A fifth counts as much; links do not count."""
    robot = load_robot("four_link")
    shares, in_use = np.full(len(robot.q), 0.9), np.ones(len(robot.q), bool)
    rows = [row for row, c in enumerate(robot.q) if c.is_motor]
    shares[rows] = motors
    in_use[rows[used:]] = False
    monkeypatch.setattr(floor_shares, "floor_shares", lambda _: shares)
    ex: Any = SimpleNamespace(setting=SimpleNamespace(robot=robot, rules=RULES), used=in_use)
    assert floor_shares.worth_little(ex) == little


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two logs of the two-link robot; and two of one with another friction at joint 2."""
    folder = tmp_path_factory.mktemp("unfollowed")
    each = []
    for robot in (two_link(), hidden()):
        with loaded(robot, folder) as fmu:
            each.append([made_log(fmu, robot, seed) for seed in (1, 2)])
    return each


@pytest.fixture
def unfollowed(monkeypatch):
    """No simulation of any fit follows its logs."""

    def refused(*_: Any) -> Any:
        raise searched.UnsimulatedFitError("a log: its fit cannot be simulated")

    monkeypatch.setattr(searched, "_aligned", refused)


def test_where_no_simulation_follows_the_logs_it_says_where_and_no_name(made, unfollowed, monkeypatch):
    def refused(*_: Any) -> Any:
        raise SimulationError("run 0: friction chatters")

    monkeypatch.setattr(laws_that_follow, "replicated", refused)
    found = pi.diagnose(two_link(), made[1][:1], heldout=made[1][1:]).diagnosis
    assert found.verdict == "unexplained"
    assert found.sentence.startswith("Something large is missing or wrong: no simulation")
    assert not found.findings
    assert not found.limits
    assert found.localised == ("joint2", "motor")
    assert found.notes[0] == "a log: its fit cannot be simulated"


@pytest.fixture(scope="module")
def carrying(tmp_path_factory):
    """A log of the two-link robot with a load of 3 kg at its tip."""
    robot = two_link().with_effect(2, "payload").with_parameters({"joint2.payload.mass": 3.0})
    with loaded(robot, tmp_path_factory.mktemp("carrying")) as fmu:
        return made_log(fmu, robot, 3)


def test_logs_that_are_fitted_each_by_itself_alone_are_said_to_be_of_different_states(made, carrying):
    empty = made[0]
    assert fitted_apart(set_up(two_link(), empty[:1])) == ""
    assert fitted_apart(set_up(two_link(), empty)) == ""
    said = fitted_apart(set_up(two_link(), [empty[0], carrying]))
    assert said.startswith(" The logs are of different states, such as a load in one of them")


def test_a_load_in_one_log_is_named_though_the_logs_are_of_different_states(made, carrying):
    """All equations leave hundreds of floors, those of the hinges too, which no parameters at all solve."""
    empty, other = made[0]
    found = pi.diagnose(two_link(), [empty, carrying], heldout=[other], force=True).diagnosis
    load = found.findings[0].tie[0]
    assert (load.effect, load.joint, load.log) == ("payload", "joint2", carrying.source)
    assert load.values["mass"] == pytest.approx(3.0, rel=0.05)


def test_where_its_equations_hold_all_the_same_it_is_an_error(made, unfollowed):
    with pytest.raises(searched.UnsimulatedFitError, match="its fit cannot be simulated"):
        pi.diagnose(two_link(), made[0])


def test_the_noise_s_floor_is_about_that_of_simulated_replicas(made):
    """Of a fit that can be simulated both are told."""
    log = made[0][:1]
    simulated = searched.searched(two_link(), log, runs_here).examination
    setting = replace(simulated.setting, unfollowed="for once")
    with workers_of(setting, runs_here) as workers:
        alone = examine(setting, workers, lambda _: None)
    shares = [np.mean(np.square(ex.floor.rms), axis=1) for ex in (alone, simulated)]
    np.testing.assert_allclose(np.sqrt(shares[0] / shares[1]), 1.0, atol=0.3)


def test_where_no_fit_through_a_low_pass_can_be_simulated_one_without_it_is_tried(monkeypatch):
    """Of joints that bend under an unknown loop, whose logs the sensors' noise blurs."""
    log: Any = SimpleNamespace(period=0.002)
    robot = replace(load_robot("four_link"), controller=None)
    filtered = robot.with_settings(processing=replace(robot.settings.processing, cutoff=20.0))
    asked = []

    def aligned(robot, *_):
        asked.append(robot.settings.processing.cutoff)
        if robot.settings.processing.filters:
            raise searched.UnsimulatedFitError("the state left the finite numbers")
        return robot

    monkeypatch.setattr(searched, "_aligned", aligned)
    found: Any = searched.searched(filtered, [log], runs_here)
    assert asked == [20.0, None]
    assert found.settings.processing.cutoff is None
    assert diagnose.left_out(filtered, found)
    assert not diagnose.left_out(filtered, filtered)
    assert not diagnose.left_out(load_robot("four_link"), found)
