"""The independent maker of logs: its mechanics against the project's, its laws, its files."""

import json
from dataclasses import replace
from functools import lru_cache

import casadi as ca
import numpy as np
import pytest
from studies.hidden_effect.generator import logs_and_key, model
from studies.hidden_effect.generator.__main__ import main
from studies.hidden_effect.generator.cases import UNOBSERVABLE, Basis, draw, perturbed, plans, running, single
from studies.hidden_effect.generator.laws import LAWS
from studies.hidden_effect.generator.run import (
    NOISELESS,
    Hidden,
    Noise,
    build,
    simulate,
    simulate_all,
    standard,
)

from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics import dynamics
from pyident.logs.log import read_log, require

ROBOT = load_robot("four_link")
JOINTS = (1, 2, 3, 4)


@lru_cache
def basis():
    return Basis.of(ROBOT)


def test_mechanics_agree_with_the_projects_own():
    arm, theirs = model.Arm(ROBOT), dynamics.mechanism(ROBOT)
    n = len(arm.names)
    a = ca.SX.sym("a", n)
    M = ca.Function("M", [arm.q, arm.p], [model.mass_matrix(arm)])
    h = ca.Function("h", [arm.q, arm.v, arm.p], [model.bias_forces(arm)])
    tip = ca.Function("tip", [arm.q], [model.tip(arm)])
    inverse = ca.Function("f", [theirs.q, theirs.v, a, theirs.bodies], [dynamics.inverse_dynamics(theirs, a)])
    their_tip = ca.Function("tip", [theirs.q], [dynamics.tip_position(theirs)])
    bodies = np.array([list(link.values.values()) for link in ROBOT.links]).T
    motors = np.zeros(n)
    motors[:4] = [ROBOT.parameters[f"joint{k}.J_m"] for k in JOINTS]
    p, rng = list(arm.numbers.values()), np.random.default_rng(0)
    for _ in range(10):
        q, v, a = (rng.uniform(-s, s, n) for s in (0.2, 2, 5))
        q[:4] = rng.uniform(-3, 3, 4)
        mine = np.array(M(q, p) @ a + h(q, v, p)).ravel() - motors * a
        assert mine == pytest.approx(np.array(inverse(q, v, a, bodies)).ravel(), abs=1e-10)
        assert np.array(tip(q)) == pytest.approx(np.array(their_tip(q)), abs=1e-13)


def test_a_closed_loop_without_friction_agrees_with_the_fmu(four_link_fmu):
    free = {f"joint{k}.coulomb": 0.0 for k in JOINTS}
    mine, theirs = _both(ROBOT.with_parameters(free), four_link_fmu, free)
    for name in (*ROBOT.coordinates, "tip.x", "tip.y", "tip.z"):
        assert np.abs(mine[name] - theirs[name]).max() < 2e-8, name
    for k in JOINTS:
        assert np.abs(mine[f"joint{k}.tau"] - theirs[f"joint{k}.tau"]).max() < 1e-4


def test_with_friction_it_agrees_with_the_fmu_but_for_its_smoothness(four_link_fmu):
    mine, theirs = _both(ROBOT, four_link_fmu, {})
    for k in JOINTS:
        difference = mine[f"joint{k}.tau"] - theirs[f"joint{k}.tau"]
        assert np.sqrt((difference**2).mean()) < 0.01 * mine[f"joint{k}.tau"].std()


def _both(robot, fmu, parameters):
    mine = simulate(robot, [], standard(robot, duration=1.0), seed=4, noise=NOISELESS)
    reference, feedforward = (mine[[f"joint{k}.{s}" for k in JOINTS]].to_numpy() for s in ("r", "tau_ff"))
    with LoadedFmu(fmu) as plant:
        experiment = Experiment(mine["time"].to_numpy(), reference, feedforward)
        return mine, plant.simulate(experiment, {**parameters, "solver.step": 1e-4})


def test_half_the_step_changes_nothing_that_sensors_could_see():
    coarse, fine = (
        simulate(ROBOT, [], standard(ROBOT, duration=1.0), 1, NOISELESS, steps) for steps in (40, 80)
    )
    for name in ROBOT.coordinates:
        assert np.abs(coarse[name] - fine[name]).max() < 5e-7


@lru_cache
def plain_log():
    return simulate(ROBOT, [], standard(ROBOT, duration=1.5), 7, NOISELESS)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(LAWS))
def test_every_law_changes_the_motion(name):
    for k in (LAWS[name].joints or JOINTS)[:2]:
        hidden = draw(name, ROBOT, basis().levels, np.random.default_rng(k), joint=k)
        if name == "offset_step":  # the moment is drawn for logs of 20 s
            continue
        log = simulate(ROBOT, [hidden], standard(ROBOT, duration=1.5), 7, NOISELESS)
        assert np.array_equal(log["joint1.tau_ff"], plain_log()["joint1.tau_ff"])
        changes = [np.abs(log[c] - plain_log()[c]).max() for c in ROBOT.coordinates]
        assert max(changes) > 1e-5, (name, k)
        assert np.isfinite(log.to_numpy()).all()


def test_the_offset_steps_in_mid_log():
    hidden = Hidden("offset_step", 1, {"size": 20.0, "moment": 9.0, "width": 0.2})
    _, forces = simulate_all(ROBOT, [hidden], standard(ROBOT, duration=16.0), 7, NOISELESS)
    force = forces["joint1.e"].to_numpy()
    assert force[:1000].max() < 1
    assert force[-100:].min() > 19


def test_potential_laws_give_back_their_energy():
    """A spring's force is the rate of its energy: kinematic error, at random points, by differences."""
    hidden = Hidden(
        "kinematic_error", 2, {"first": 1e-3, "second": 2e-4, "teeth": 9.0, "phase1": 0.4, "phase2": 1.0}
    )
    arm = build(ROBOT, [hidden])
    force = ca.Function("f", [arm.q, arm.p], [arm.hidden])
    q, k1 = np.random.default_rng(1).uniform(-0.2, 0.2, len(arm.names)), ROBOT.parameters["joint2.k[1]"]

    def energy(q):
        e, x = q[1], q[arm.at("joint2.eps[1]")]
        delta = 1e-3 * np.sin(9 * e + 0.4) + 2e-4 * np.sin(18 * e + 1.0)
        return k1 * ((x - delta) ** 2 - x**2) / 2

    slope = [(energy(q + d) - energy(q - d)) / 2e-6 for d in np.eye(len(q)) * 1e-6]
    assert np.array(force(q, list(arm.numbers.values()))).ravel() == pytest.approx(slope, abs=1e-3)


@pytest.mark.parametrize("name", ["gravity_spring", "joint_spring"])
def test_springs_span_the_joint(name):
    """They load motor and transmission alike, and by the sum of both angles only."""
    arm = build(ROBOT, [draw(name, ROBOT, basis().levels, np.random.default_rng(2), joint=2)])
    force = ca.Function("f", [arm.q, arm.p], [arm.hidden])
    e, eps = arm.at("joint2.e"), arm.at("joint2.eps[1]")
    q = np.random.default_rng(3).uniform(-0.2, 0.2, len(arm.names))
    taken = np.array(force(q, list(arm.numbers.values()))).ravel()
    assert abs(taken[e]) > 1
    assert taken[eps] == pytest.approx(taken[e], rel=1e-12)
    assert not np.delete(taken, [e, eps]).any()
    q[e], q[eps] = q[e] + 0.1, q[eps] - 0.1
    assert np.array(force(q, list(arm.numbers.values()))).ravel() == pytest.approx(taken, rel=1e-12)


def test_a_delay_is_a_delay_and_a_limit_limits():
    plan = standard(ROBOT, duration=1.5)
    free = float(np.abs(plain_log()["joint1.tau"].to_numpy()).max())
    limited = Hidden("torque_saturation", 1, {"limit": 2 * free, "soft": 0.0})
    assert simulate(ROBOT, [limited], plan, 7, NOISELESS).equals(plain_log())
    late = simulate(ROBOT, [Hidden("torque_delay", 1, {"samples": 0.5})], plan, 7, NOISELESS)
    never = simulate(ROBOT, [Hidden("torque_delay", 1, {"samples": 0.0})], plan, 7, NOISELESS)
    assert never.equals(plain_log())
    first = np.abs(late["joint1.e"].to_numpy() - plain_log()["joint1.e"].to_numpy())
    assert first[0] == 0
    assert first[1] > 0


def test_true_robots_are_off_and_physical():
    rng = np.random.default_rng(5)
    for _ in range(20):
        robot = perturbed(ROBOT, rng)
        for name in ("joint1.J_m", "joint2.coulomb", "joint3.k[2]", "joint4.d[1]", "link2.m"):
            assert 0.0999 < abs(robot.parameters[name] / ROBOT.parameters[name] - 1) < 0.2501
        for link in robot.links:
            com = np.array(link.ms) / link.m
            xx, xy, xz, yy, yz, zz = link.J
            J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            J -= link.m * (com @ com * np.eye(3) - np.outer(com, com))
            principal = np.linalg.eigvalsh(J)
            assert principal[0] > 0
            assert principal[2] < principal[0] + principal[1]


def test_the_linear_loop_foretells_an_instability():
    """Without dry friction, in one pose: the run grows when the linear loop does, and by its eigenvalue."""
    rng, pose = np.random.default_rng(6), np.full((1, 4), 0.1)
    hot = perturbed(ROBOT, rng)
    while basis().loop.slowest_decay(hot, pose) < 1.005:
        hot = perturbed(ROBOT, rng)
    hot = hot.with_parameters({f"joint{k}.coulomb": 0.0 for k in JOINTS})
    plan = standard(ROBOT, duration=6.0, swing=(0.0,) * 4, start=(0.1,) * 4, rms=(1e-3,) * 4)
    log = simulate(hot, [], plan, 1, NOISELESS)
    error = np.abs(log[[f"joint{k}.e" for k in JOINTS]].to_numpy() - 0.1).max(axis=1)
    growth = (error[1375:1500].max() / error[1125:1250].max()) ** (1 / 250)
    assert growth == pytest.approx(basis().loop.slowest_decay(hot, pose), abs=3e-4)
    assert basis().loop.slowest_decay(running(basis(), rng), pose) < 1


def test_noise_has_its_size_and_enters_the_loop():
    plan = standard(ROBOT, duration=1.0)
    noisy = simulate(ROBOT, [], plan, 3, Noise(e=0.0, eps=1e-6, tip=5e-6))
    clean = simulate(ROBOT, [], plan, 3, NOISELESS)
    assert np.std(noisy["joint2.eps[3]"] - clean["joint2.eps[3]"]) == pytest.approx(1e-6, rel=0.2)
    assert np.std(noisy["tip.y"] - clean["tip.y"]) == pytest.approx(5e-6, rel=0.2)
    assert noisy["joint1.tau"].equals(clean["joint1.tau"])
    loop = simulate(ROBOT, [], plan, 3, Noise(e=2e-6))
    assert np.std(loop["joint1.tau"] - clean["joint1.tau"]) > 0.1


def test_the_held_out_log_is_another_trajectory():
    first, second, other = plans(ROBOT, np.random.default_rng(0))
    assert first == second
    assert all(a != b for a, b in zip(first.period, other.period, strict=True))
    assert all(a > b for a, b in zip(first.swing, other.swing, strict=True))


def test_files_are_logs_and_keys_stay_apart(tmp_path, capsys):
    main(["--seed", "2", "--cases", "viscous_drift@3", "-o", str(tmp_path)])
    name = capsys.readouterr().out.strip()
    folder, sealed = tmp_path / "logs" / name, tmp_path / "sealed" / name
    assert sorted(p.name for p in folder.iterdir()) == ["heldout.parquet", "train1.parquet", "train2.parquet"]
    logs = [read_log(path) for path in sorted(folder.iterdir())]
    for log in logs:
        require(log, ROBOT, 1000)
        assert len(log) == 5001
        assert log.period == pytest.approx(0.004)
    assert not logs[1].frame["joint1.tau_ff"].equals(logs[2].frame["joint1.tau_ff"])
    key = json.loads((sealed / "key.json").read_text())
    assert key["laws"][0]["law"] == "viscous_drift"
    assert key["laws"][0]["joint"] == 3
    assert "viscous" not in name
    assert 0.05 < key["shares"]["train1"]["joint3.e"]["share"] < 0.4


def test_wrong_cases_are_explained(tmp_path):
    with pytest.raises(ValueError, match="unknown case 'stribek'"):
        single("stribek", basis(), 0)


def _hidden_log(name, log=0, duration=8.0):
    case = single(name, basis(), 1)
    return case, simulate(
        case.robot, case.laws, replace(case.plans[log], duration=duration), case.seed, NOISELESS
    )


@pytest.mark.slow
@pytest.mark.parametrize("log", [0, 2])
def test_data_that_cannot_show_an_effect_do_not(log):
    case, frame = _hidden_log("stribeck_never_slow", log)
    speed = np.diff(frame["joint1.e"].to_numpy()) / 0.004
    assert float(np.abs(speed).min()) > 10 * case.laws[0].constants["speed"]
    case, frame = _hidden_log("saturation_above_every_torque", log)
    limited = case.laws[0]
    assert (
        float(np.abs(frame[f"joint{limited.joint}.tau"].to_numpy()).max()) < 0.8 * limited.constants["limit"]
    )
    case, frame = _hidden_log("backlash_on_one_flank", log)
    assert float(np.abs(frame["joint2.eps[1]"].to_numpy()).min()) > 1.5 * case.laws[0].constants["half"]
    case, frame = _hidden_log("hardening_below_noise", log)
    hardening = case.laws[0]
    _, forces = simulate_all(case.robot, case.laws, standard(ROBOT, duration=2.0), case.seed, NOISELESS)
    stiffness = case.robot.parameters[f"joint{hardening.joint}.k[1]"]
    assert float(np.abs(forces[f"joint{hardening.joint}.eps[1]"].to_numpy()).max()) < 0.5 * stiffness * 1e-6
    assert set(UNOBSERVABLE) > {"payload_in_every_log", "viscous_drift_too_slow"}


def test_a_case_whose_loop_is_unstable_is_drawn_again(monkeypatch):
    (case,) = logs_and_key.cases_of(["torque_delay@2"], 3)
    tried = []

    def runs(case, jobs):
        tried.append(case)
        if len(tried) == 1:
            raise logs_and_key.UnstableLoop("it runs away")
        return []

    monkeypatch.setattr(logs_and_key, "_runs", runs)
    drawn, _ = logs_and_key._running(case, 1)
    assert drawn.id == case.id
    assert [(law.law, law.joint) for law in drawn.laws] == [("torque_delay", 2)]
    assert drawn.robot.parameters != case.robot.parameters
