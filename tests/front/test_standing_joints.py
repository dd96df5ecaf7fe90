"""A joint that stands still during a whole log: nothing is said of it, and nothing stumbles over it."""

import json

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from two_link_logs import TWO_LINK, loaded, two_link

from flexmodels.inputs import Experiment
from pyident.cli.main import main
from pyident.conditioning.standing import standing, standing_in, standing_joints
from pyident.conditioning.weak_form import condition
from pyident.logs.log import Log, write_log

PERIOD = 1 / 250


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Four seconds in which joint 1 swings and dry friction holds joint 2 where it is."""
    folder = tmp_path_factory.mktemp("standing")
    time = np.arange(1000) * PERIOD
    reference = np.column_stack([0.6 * (1 - np.cos(3 * time)), np.zeros(len(time))])
    waves = np.cos(2 * np.pi * np.outer(time, np.linspace(0.5, 30, 20)) + np.arange(20) ** 2).sum(axis=1)
    robot = two_link().with_parameters({"joint2.coulomb": 400.0})
    with loaded(robot, folder) as fmu:
        frame = fmu.simulate(Experiment(time, reference, np.column_stack([3 * waves, 0 * time])))
    assert np.ptp(frame["joint2.e"]) < 1e-12  # what the tests below are about
    write_log(Log(frame, "still"), folder / "still.parquet")
    return folder


def run(folder, *arguments):
    out = folder / "out.json"
    done = CliRunner().invoke(main, [*map(str, arguments), "--json", str(out), "--overwrite"])
    assert done.exit_code == 0, done.output
    told = json.loads(out.read_text(), parse_constant=pytest.fail)  # JSON knows no NaN
    return done.output, told


def test_identify_says_which_joint_stands_still(folder):
    output, told = run(folder, "identify", TWO_LINK, folder / "still.parquet", "-o", folder / "new.toml")
    assert "joint2 stands still" in output
    assert told["relative_error_percent"]["joint2"] is None
    assert told["relative_error_percent"]["joint1"] < 1
    for name in ("J_m", "coulomb", "viscous"):
        assert told["parameters"][f"joint2.{name}"]["identifiable"] == "no"
    moving = told["parameters"]["joint1.coulomb"]
    assert moving["value"] == pytest.approx(two_link().parameters["joint1.coulomb"], rel=0.01)


def test_compare_has_no_share_of_an_equation_that_is_never_in_use(folder):
    output, told = run(folder, "compare", TWO_LINK, folder / "still.parquet", "--set", "joint2.coulomb=400")
    assert "joint2 stands still" in output
    (log,) = told["logs"].values()
    assert log["torque"]["joint2"]["nrmse_percent"] is None
    assert log["torque"]["joint1"]["nrmse_percent"] < 1


def test_diagnose_names_nothing_where_nothing_is_hidden(folder):
    output, told = run(folder, "diagnose", TWO_LINK, folder / "still.parquet")
    assert "joint2 stands still" in output
    assert told["verdict"] in ("nothing_detectable", "cannot_tell")
    assert told["findings"] == []
    assert "joint2, motor side" not in output  # that says how far a residual lies below its floor
    states = {(p["joint"], p["balance"]): p["state"] for p in told["places"]}
    assert states.pop(("joint2", "motor")) == "unobserved"
    assert set(states.values()) == {"in_order"}


def test_a_brakes_play_is_no_motion():
    assert standing_joints(np.array([2.0, 1e-5, 0.5, 0.0])) == [2, 4]


def test_two_joints_stand_in_all_logs_or_not_at_all():
    robot = two_link()
    time = np.arange(50) * PERIOD
    still, moving = np.full(50, 0.3), np.sin(time)
    logs = [
        Log(pd.DataFrame({"time": time, "joint1.e": moving, "joint2.e": second}), name)
        for name, second in (("a", still), ("b", moving))
    ]
    (sentence,) = standing(robot, logs[:1])
    assert sentence.startswith("joint2 stands still in a:")
    assert standing(robot, logs) == []


def test_a_joint_that_is_parked_elsewhere_in_each_log_stands_still():
    robot, time = two_link(), np.arange(1000) * PERIOD
    names = [*robot.coordinates, *robot.torques]
    swings = pd.DataFrame(0.0, index=range(1000), columns=names).assign(**{"joint1.e": np.sin(time)})
    frames = [swings.assign(time=time, **{"joint2.e": place}) for place in (0.3, -0.8)]
    motions = [condition(Log(frame, "parked"), robot).motion for frame in frames]
    assert standing_in(motions, 2) == [2]


def test_what_a_held_joint_creeps_within_its_play_is_no_equation_of_its_motor():
    """A hundredth of a milliradian to and fro, beside a joint that swings by one radian."""
    time = np.arange(1000) * PERIOD
    names = [*two_link().coordinates, *two_link().torques]
    frame = pd.DataFrame({"time": time} | {name: 0.0 * time for name in names})
    frame["joint1.e"], frame["joint2.e"] = 0.5 * np.sin(3 * time), 5e-6 * np.sin(3 * time)
    part = condition(Log(frame, "held"), two_link())
    assert part.use[:, 0].mean() > 0.8
    assert not part.use[:, 1].any()
    assert part.use[:, 2:].all()  # its hinge is no dry friction
