"""Machines drawn at random: the two simulators agree, sizes are what they say, and the study counts right."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from scipy.signal import butter, sosfiltfilt
from studies.detection_limits.study import run as put_to_the_proof
from studies.foreign_logs import study
from studies.foreign_logs.cases import case_list
from studies.foreign_logs.closed_loop import simulated
from studies.foreign_logs.generator import Truth, made
from studies.foreign_logs.machines import Error, drawn_machine, owners_file
from studies.foreign_logs.methods import Answer, named
from studies.foreign_logs.motions import drawn_plan
from studies.foreign_logs.oracle import Oracle
from studies.foreign_logs.scoring import Scored, table
from studies.foreign_logs.sensors import Sensors, as_log

from pyident.cli.main import main
from pyident.conditioning.motion import Motion
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.regression.regressor import generalised_forces
from pyident.simulation.fmu_runs import runs_here

pytest.importorskip("pinocchio", reason="Pinocchio (package pin) makes these logs and is not installed")
FINE = Sensors(bits=40, white=0.0, slow=0.0, corner=1.0)


def moved(seed: int):
    rng = np.random.default_rng(seed)
    machine = drawn_machine(rng)
    time = np.arange(0, 4, 0.01)
    q, v, a = drawn_plan(rng, machine.sliders, 4.0, True, False).at(time)
    return machine, time, q, v, a


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_pinocchio_gives_the_forces_of_our_own_mechanics(seed):
    """Φ p with the true bodies, rotors and frictions."""
    machine, time, q, v, a = moved(seed)
    oracle = Oracle(machine)
    values = {f"joint{k + 1}.J_m": machine.rotor[k] for k in range(len(machine.rotor))}
    values |= {f"joint{k + 1}.coulomb": machine.coulomb[k] for k in range(len(machine.rotor))}
    values |= {f"joint{k + 1}.viscous": machine.viscous[k] for k in range(len(machine.rotor))}
    robot = machine.robot.with_parameters({name: float(value) for name, value in values.items()})
    p = np.array(list(robot.parameters.values()))
    ours = generalised_forces(robot, Motion(q, v, a, time=time), p)
    theirs = oracle.plain(oracle.state(time, q, v, a), a)
    assert ours == pytest.approx(theirs, abs=1e-9 * np.abs(theirs).max())


def test_mujoco_in_its_loop_obeys_pinocchio():
    """Away from reversals, where MuJoCo's friction is not rounded."""
    pytest.importorskip("mujoco")
    rng = np.random.default_rng(0)
    machine = drawn_machine(rng, 2)
    machine = replace(machine, coulomb=0 * machine.coulomb)
    plan = drawn_plan(rng, machine.sliders, 5.0, True, False)
    time, q, tau = simulated(machine, plan, [], FINE, 5.0, 1)
    sos = butter(4, 0.04, output="sos")
    smooth = sosfiltfilt(sos, q, axis=0)
    speed = np.gradient(smooth, time, axis=0)
    acceleration = np.gradient(speed, time, axis=0)
    oracle = Oracle(machine)
    expected = oracle.plain(oracle.state(time, smooth, speed, acceleration), acceleration)
    left = sosfiltfilt(sos, tau - expected, axis=0)[500:-500]
    assert np.sqrt(np.mean(left**2, axis=0)).max() < 5e-3 * np.sqrt(np.mean(tau**2))


def test_what_bodies_and_friction_can_do_is_nothing_beyond_them():
    machine, time, q, v, a = moved(1)
    oracle = Oracle(machine)
    state = oracle.state(time, q, v, a)
    plain = oracle.plain(state, a)
    assert np.abs(oracle.beyond(state, a, plain)).max() < 1e-6 * np.abs(plain).max()
    cable = np.maximum(q, 0.1)
    assert np.abs(oracle.beyond(state, a, cable)).max() > 1e-3


def test_deviations_are_those_of_the_best_estimate():
    """Of white noise, alike at all joints, what bodies leave of a force; uneven noise lets them take more."""
    machine, time, q, v, a = moved(1)
    oracle = Oracle(machine)
    state = oracle.state(time, q, v, a)
    rng, n = np.random.default_rng(0), q.shape[1]
    force = np.abs(q) * rng.uniform(0.5, 2, n)
    even = np.full((len(time) // 2 + 1, n), 0.04)
    left = np.linalg.norm(oracle.beyond(state, a, force)) / 0.2
    assert oracle.deviations(state, a, force, even) == pytest.approx(left, rel=0.02)
    uneven = even * np.geomspace(1, 100, n)
    by_joint = np.linalg.norm(oracle.beyond(state, a, force) / np.sqrt(uneven[0]))
    assert oracle.deviations(state, a, force, uneven) <= by_joint * 1.02


def test_the_file_of_the_owner_has_the_error_that_is_to_be_found():
    machine, *_ = moved(2)
    robot = owners_file(machine, np.random.default_rng(0), (Error("origin[y]", 1, 2e-3),))
    true, filed = machine.robot.joints[0].origin, robot.joints[0].origin
    assert np.subtract(true, filed) == pytest.approx([0, 2e-3, 0])
    off = [mine.m / theirs.m - 1 for mine, theirs in zip(robot.links, machine.robot.links, strict=True)]
    assert all(0.05 <= abs(x) <= 0.15 for x in off)


def test_more_cases_begin_with_the_same_and_a_case_is_the_same_again():
    assert case_list(7, 12)[:5] == case_list(7, 5)
    case = replace(case_list(7, 2)[1], closed=False)
    one, two = made(case, 2), made(case, 2)
    assert one.fit.equals(two.fit)
    assert one.truth == two.truth
    assert not one.fit["q1"].equals(one.heldout["q1"])


def shifted(*amounts: float | None) -> Answer:
    """A tie of other errors of the robot file, and the shift as its last."""
    tie = [*(("encoder_zero", k + 1) for k in range(len(amounts) - 1)), ("origin[x]", 1)]
    return Answer("missing_effect" if len(tie) == 1 else "cannot_tell", [tie], amounts)


def test_answers_are_counted():
    spring = Truth("hose", (("joint_spring", 2), ("gravity_spring", 2)), 8.0)
    shift = Truth("geometry", (("origin[x]", 1),), 1.0, 2e-3)
    tie = Answer("cannot_tell", [[("torque_ripple", 2), ("joint_spring", 2)]])
    cases = [
        Scored("null", False, (), {"diagnosis": Answer("nothing_detectable", [])}),
        Scored("null", True, (), {"diagnosis": named([("stribeck", 1)])}),
        Scored("null", True, (), {"diagnosis": named([("torque_delay", 1)])}, besides=(("torque_delay", 1),)),
        Scored("null", True, (), {"diagnosis": Answer("unexplained", [])}, besides=(("torque_delay", 1),)),
        Scored("strong", False, (spring,), {"diagnosis": tie}),
        Scored("strong", False, (spring,), {}, "LogError: no"),
        Scored("geometry", False, (shift,), {"diagnosis": shifted(2.3e-3)}),
        Scored("geometry", False, (shift,), {"diagnosis": shifted(2.5e-3)}),
        Scored("geometry", False, (shift,), {"diagnosis": shifted(2e-3, 2.1e-3)}),
        Scored("outside", False, (), {"diagnosis": Answer("unexplained", [])}),
    ]  # fmt: skip
    value = {r["what"]: r["value"].split(" (")[0] for r in table(cases, ["diagnosis"])}
    assert value["false alarm, ordinary"] == "0 of 1"
    assert value["false alarm, difficult"] == "2 of 3"
    assert value["strong: in the first tie"] == "1 of 2"
    assert value["strong: strictly first"] == "0 of 2"
    assert value["single: confidently wrong"] == "1 of 2"
    assert value["geometry: named, value within 20 %"] == "1 of 3"
    assert value["geometry: in the first tie, value within 20 %"] == "2 of 3"
    assert value["outside: unexplained or a fair alias"] == "1 of 1"
    assert value["of all findings with one name: right"] == "3 of 4"
    assert value["of all findings in a tie: the truth among them"] == "2 of 2"
    assert value["of all findings of the robot file: right"] == "3 of 3"
    assert value["cases that failed"] == "1 of 10"


def strong(*found: tuple[str, int, float]) -> Answer:
    return replace(named([(e, k) for e, k, _ in found]), strengths=[s for _, _, s in found])


def test_other_methods_are_counted_as_careful_as_the_diagnosis_too():
    """Its strength 3 in a log with nothing hidden would be an alarm, and so would 3.2 at a wrong joint."""
    spring, ripple = (Truth(law, ((law, 1),), 8.0) for law in ("joint_spring", "torque_ripple"))
    quiet, own = Answer("nothing_detectable", []), (("torque_delay", 1),)
    false = strong(("stribeck", 1, 3), ("backlash", 1, 1))
    first, both = strong(("joint_spring", 1, 3.5)), strong(("joint_spring", 1, 9), ("torque_ripple", 1, 2))
    cases = [
        Scored("null", True, (), {"diagnosis": quiet, "theirs": strong(("torque_delay", 1, 7))}, besides=own),
        Scored("null", False, (), {"diagnosis": quiet, "theirs": false}),
        Scored("strong", False, (spring,), {"diagnosis": quiet, "theirs": first}),
        Scored("weak", False, (spring,), {"diagnosis": quiet, "theirs": strong(("joint_spring", 2, 3.2))}),
        Scored("pair", False, (spring, ripple), {"diagnosis": quiet, "theirs": both}),
    ]  # fmt: skip
    value = {r["what"]: r["value"].split(" (")[0] for r in table(cases, ["diagnosis", "theirs"])}
    assert value["theirs: single: confidently wrong"] == "1 of 2"
    assert value["theirs, wrong as seldom: single: confidently wrong"] == "0 of 2"
    assert value["theirs: false alarm, ordinary"] == "1 of 1"
    assert value["theirs: two at once: both"] == "1 of 1"
    assert value["theirs, wrong as seldom: false alarm, ordinary"] == "0 of 1"
    assert value["theirs, wrong as seldom: false alarm, difficult"] == "0 of 1"
    assert value["theirs, wrong as seldom: strong: strictly first"] == "1 of 1"
    assert value["theirs, wrong as seldom: two at once: both"] == "0 of 1"


def nothing(robot, fit, heldout):
    return []


def test_a_method_of_ones_own_is_scored_and_answers_are_kept(tmp_path):
    methods = {"mine": nothing}
    first = study.run(tmp_path, lambda _: None, seed=3, cases=1, methods=methods, joints=1)
    assert {"what": "mine: false alarm, ordinary", "value": "0 of 1 (95 %: 0 to 79 %)"}.items() <= next(
        r for r in first.rows if r["what"].startswith("mine: false alarm, ordinary")
    ).items()
    answer = next(tmp_path.glob("*/answers/001.json"))
    said = json.loads(answer.read_text())
    assert not said["failure"]
    before = answer.stat().st_mtime_ns
    assert study.run(tmp_path, lambda _: None, seed=3, cases=1, methods=methods, joints=1).rows == first.rows
    assert answer.stat().st_mtime_ns == before


def test_a_study_that_draws_nothing_takes_no_seed(tmp_path):
    done = CliRunner().invoke(main, ["study", "paper", "--seed", "3", "-o", str(tmp_path)])
    assert done.exit_code == 2
    assert "study paper takes no --seed" in done.output


def test_a_diagnosis_ends_where_laws_of_a_set_are_exchanged_for_those_of_another_joint():
    """Two joints in a loop; the law that comes nearest at one is exchanged for one that acts at the other."""
    machine = made(case_list(2056, 94)[-1])
    fit = as_log(machine.robot, machine.fit, "fit")
    heldout = as_log(machine.robot, machine.heldout, "held out")
    found = concluded(searched(machine.robot, [fit], runs_here), runs_here, [heldout])
    assert found.verdict != "nothing_detectable"


def test_a_wave_that_is_none_beside_others_ends_no_diagnosis():
    """A cable over an angle, a spring with slack: beside it no order of a ripple has two flanks."""
    machine = made(case_list(2341, 85)[84], 7)
    fitted, unseen = (as_log(machine.robot, frame, "log") for frame in (machine.fit, machine.heldout))
    found = concluded(searched(machine.robot, [fitted], runs_here), runs_here, [unseen])
    assert [[n.effect for n in f.tie] for f in found.findings] == [["slack_spring"]]


def test_a_ripple_is_named_where_one_of_another_size_at_every_speed_takes_friction_for_itself():
    """That holds on no other log; friction that falls with the speed was then missed as well."""
    machine = made(case_list(2461, 118)[117], 7)
    fitted, unseen = (as_log(machine.robot, frame, "log") for frame in (machine.fit, machine.heldout))
    found = concluded(searched(machine.robot, [fitted], runs_here), runs_here, [unseen])
    assert {f.tie[0].effect for f in found.findings} == {"torque_ripple", "stribeck"}
    assert {tuple(truth.names[0]) for truth in machine.truth} == {("torque_ripple", 1), ("stribeck", 1)}


@pytest.mark.slow
def test_a_law_at_its_limit_is_put_into_a_quiet_log(tmp_path):
    """Whether it is named or not, the sentence and the table say the same."""
    result = put_to_the_proof(tmp_path, lambda _: None, seed=2101, cases=1, laws=1)
    (found,) = pd.read_csv(tmp_path / "detection_limits.csv").to_dict("records")
    assert 0 < found["share_percent"] < 100
    assert found["named"] == (f"{found['effect']} at {found['joint']}" in found["sentence"])
    assert result.rows[0]["value"].startswith(f"{int(found['named'])} of 1 ")
