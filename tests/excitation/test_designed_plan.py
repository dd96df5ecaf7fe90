"""A plan from design to file: it runs as it is, keeps its limits, and a check says what breaks them."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from planned_joint import FEW, limited

import pyident as pi
from flexmodels.files.robot_file import load_robot
from flexmodels.robot import RobotError
from pyident.cli.main import main
from pyident.excitation.fourier import Reference
from pyident.excitation.rehearsals.rehearsal import others_like, rehearsal
from pyident.excitation.tables import message, table


@pytest.fixture(scope="module")
def planned() -> pi.Planned:
    return pi.excite(limited(), **FEW)


@pytest.fixture(scope="module")
def files(planned, tmp_path_factory):
    """A folder with the plan and two robots: one that may run it and one that is too weak."""
    folder = tmp_path_factory.mktemp("plan")
    planned.save(folder / "plan.parquet")
    pi.save_robot(limited(), folder / "robot.toml")
    pi.save_robot(limited(effort=8.0), folder / "weak.toml")
    return folder


def test_the_simulated_robot_keeps_the_limits(planned):
    log = pi.simulate(limited(), planned.plan)
    e, tau = log.signals(["joint1.e", "joint1.tau"]).T
    assert np.abs(e).max() <= 1.5
    assert np.abs(np.gradient(e, log.period)).max() <= 3.0
    assert np.abs(tau).max() <= 60.0
    assert np.ptp(e) > 0.3  # it moves, through a tenth of its range


def test_what_is_predicted_is_what_noisy_logs_scatter_by(planned):
    robot, sigma = limited(), 1e-5
    clean = pi.simulate(robot, planned.plan).frame
    rng = np.random.default_rng(3)
    found = []
    for _ in range(40):
        noise = sigma * rng.standard_normal(len(clean))
        log = pi.Log(clean.assign(**{"joint1.e": clean["joint1.e"] + noise}))
        fit = pi.identify(robot, log, estimator="ols")
        found.append(fit.to_frame().loc[["joint1.viscous", "joint1.coulomb"], "value"].tolist())
    expected = planned.to_frame().loc[["joint1.viscous", "joint1.coulomb"], "std_regression"].tolist()
    assert np.std(found, axis=0) == pytest.approx(expected, rel=0.35)  # 40 draws: 11 % on a deviation


def test_what_identify_is_to_say_it_says_of_logs_with_noise_in_the_loop(planned):
    """Its values scatter by the promised standard deviations, its own intervals say them (3 s: by 50 %)."""
    robot, names = limited(), ["joint1.viscous", "joint1.coulomb"]
    with rehearsal(robot) as own:
        logs = own.noisy(planned.plan, {name: 1e-5 for name in robot.coordinates}, range(300, 320))
    fits = [pi.identify(robot, log).to_frame().loc[names] for log in logs]
    promised = planned.to_frame().loc[names, "std"].tolist()
    assert np.std([f["value"].tolist() for f in fits], axis=0) == pytest.approx(promised, rel=0.5)
    assert np.median([f["std"].tolist() for f in fits], axis=0) == pytest.approx(promised, rel=0.5)


def test_a_check_tells_what_a_weaker_robot_would_break(planned):
    good = pi.check_plan(planned.plan, limited(), floor=None, others=30)
    assert good.safe
    assert (good.broken, good.others) == (0, 30)
    weak = pi.check_plan(planned.plan, limited(effort=8.0), floor=None)
    assert not weak.safe
    assert {v.what for v in weak.violations} == {"torque"}
    assert weak.broken == weak.others
    assert all("its limit is 8 N.m" in v.sentence for v in weak.violations)


def test_other_robots_are_off_by_what_is_said_and_physical():
    robot = limited()
    for other in others_like(robot, 20):
        ratio = other.parameters["joint1.viscous"] / robot.parameters["joint1.viscous"]
        assert 0.10 <= abs(ratio - 1) <= 0.25
        link = other.links[0]
        com = np.array(link.ms) / link.m
        xx, xy, xz, yy, yz, zz = link.J
        J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        about_com = J - link.m * (com @ com * np.eye(3) - np.outer(com, com))
        assert np.linalg.eigvalsh(about_com).min() > -1e-12


def test_commands_check_simulate_and_export_the_file(files):
    run = CliRunner()
    plan, robot = str(files / "plan.parquet"), str(files / "robot.toml")
    good = run.invoke(main, ["plan", "check", plan, robot, "--no-floor", "--json", str(files / "c.json")])
    assert good.exit_code == 0, good.output
    assert json.loads((files / "c.json").read_text())["safe"] is True
    bad = run.invoke(main, ["plan", "check", plan, str(files / "weak.toml"), "--no-floor"])
    assert bad.exit_code == 1
    assert "the torque of" in " ".join(bad.output.split())
    log = str(files / "log.parquet")
    assert run.invoke(main, ["simulate", robot, "--experiment", plan, "-o", log]).exit_code == 0
    trajectory = str(files / "t.json")
    assert run.invoke(main, ["plan", "export", plan, robot, "-o", trajectory, "--rate", "50"]).exit_code == 0
    points = json.loads((files / "t.json").read_text())["points"]
    assert len(points) == 151
    assert points[50]["time_from_start"] == {"sec": 1, "nanosec": 0}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--limit", "joint9.speed=1"], "there is no limit joint9.speed"),
        (["--limit", "joint1.lower=2"], "joint1.lower must be below joint1.upper"),
        (["--duration", "0.2"], "51 samples are too few"),
        (["--separate", "stribeck@1", "nonsense"], "is not EFFECT@JOINT"),
        (["--reveal", "stribeck@4"], "has no joint 4"),
        (["--criterion", "beauty"], "'beauty' is not one of"),
        (["--noise", "joint7.e=1e-5"], "has no sensor joint7.e"),
    ],
)
def test_bad_input_ends_in_one_sentence_and_writes_nothing(files, words, said):
    output = files / "never.parquet"
    found = CliRunner().invoke(main, ["excite", str(files / "robot.toml"), "-o", str(output), *words])
    assert found.exit_code == 2
    assert said in found.output
    assert not output.exists()


def test_a_message_and_a_table_hold_the_motion():
    time = np.array([0.0, 0.5, 1.25])
    motion = Reference(time, np.array([[0.0], [1.0], [2.0]]), np.ones((3, 1)), np.zeros((3, 1)))
    told = message(limited(), motion)
    assert told["joint_names"] == ["joint1"]
    assert told["points"][2]["time_from_start"] == {"sec": 1, "nanosec": 250_000_000}
    assert told["points"][1]["positions"] == [1.0]
    assert table(limited(), motion, degrees=True)["joint1.position [deg]"].tolist() == pytest.approx(
        [0.0, 57.29577951, 114.59155903]
    )


def test_a_plan_whose_log_could_not_be_identified_is_refused_before_the_search():
    with pytest.raises(RobotError, match=r"2001 samples are too few.*give a longer duration"):
        pi.excite(load_robot("tx40"), criterion="condition", duration=8.0, floor=None)
