"""Adding an effect: the true one is kept, a wrong one is refused with a reason."""

from dataclasses import replace

import pytest
from click.testing import CliRunner
from two_link_logs import hidden, in_process, loaded, made_log, two_link

from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.inputs import SimulationError
from flexmodels.robot import RobotError
from pyident.cli.main import main
from pyident.extension import add_effect as extension
from pyident.extension.add_effect import add_effect
from pyident.extension.extended_robot import require_new
from pyident.extension.fit import fit_to
from pyident.extension.split import split
from pyident.logs.log import LogError, write_log
from pyident.regression.descriptions import corrected, value_of
from pyident.verbs import judge


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("extend")


@pytest.fixture(scope="module")
def logs(folder):
    with loaded(hidden(), folder) as fmu:
        return [made_log(fmu, hidden(), seed) for seed in (1, 2)]


def test_the_true_effect_is_accepted(folder, logs):
    found = add_effect(two_link(), 2, "asymmetric_coulomb", logs, [], in_process, lambda _: None)
    assert found.accepted, found.reason
    true = hidden().parameters
    for name in ("coulomb", "viscous"):
        key = f"joint2.asymmetric_coulomb.{name}"
        assert found.robot.parameters[key] == pytest.approx(true[key], rel=0.1)
    names = [(step.name, step.data) for step in found.waterfall]
    assert names == [
        (name, data) for name in ("torque joint2.e", "simulated tip") for data in ("held out", "fitted")
    ]
    for torque, tip in (found.waterfall[::2], found.waterfall[1::2]):
        assert torque.after < 1.1 * torque.floor < torque.before
        assert tip.after < tip.before / 1.5
    assert [log.log for log in found.after] == [logs[1].source]  # the figures of the JSON are of unseen data


def test_a_wrong_effect_is_refused(folder, logs):
    found = add_effect(two_link(), 1, "stribeck", logs[:1], logs[1:], in_process, lambda _: None)
    assert not found.accepted
    assert found.reason.startswith("stribeck at joint 1 is refused: ")
    assert found.asked.admission.reason in found.reason  # the gate of the diagnosis, in its words


def test_a_law_whose_model_cannot_be_simulated_is_refused(monkeypatch, folder, logs):
    def only_without(robot, *rest):
        if robot.parameters.keys() > two_link().parameters.keys():
            raise SimulationError("it rings")
        return fit_to(robot, *rest)

    monkeypatch.setattr(extension, "fit_to", only_without)
    found = add_effect(two_link(), 1, "stribeck", logs[:1], logs[1:], in_process, lambda _: None)
    assert not found.accepted
    assert found.reason.endswith("is refused: the model fitted with it cannot be simulated (it rings)")
    assert found.json()["mean_square_fall_percent"] == {"equations": 0.0, "simulation": 0.0}
    assert found.before == found.after


def test_what_is_held_out(logs):
    assert [log.source for log in split(logs, []).judged] == ["log 2"]
    assert split(logs[:1], logs[1:]).fitted == logs[:1]
    alone = split(logs[:1], [])
    assert len(alone.fitted[0]) == round(len(logs[0]) * 2 / 3) - 1
    assert alone.judged == logs[:1]
    assert alone.since[0] == pytest.approx(len(alone.fitted[0]) * logs[0].period)
    with pytest.raises(LogError, match="2 samples are too few to hold some of them out"):
        split([replace(logs[0], frame=logs[0].frame.head(2))], [])


def test_an_effect_is_not_added_twice(folder, logs):
    with pytest.raises(RobotError, match="has the effect asymmetric_coulomb at joint 2 already"):
        add_effect(hidden(), 2, "asymmetric_coulomb", logs, [], in_process, lambda _: None)


def test_the_command(monkeypatch, folder, logs, tmp_path):
    monkeypatch.setattr(judge, "FmuRuns", in_process)
    save_robot(two_link(), tmp_path / "old.toml")
    write_log(logs[0], tmp_path / "log.parquet")

    def add(effect, joint, new):
        words = ["add", tmp_path / "old.toml", effect, "--joint", joint, tmp_path / "log.parquet", "-o", new]
        return CliRunner().invoke(main, [str(w) for w in words])

    done = add("asymmetric_coulomb", 2, tmp_path / "new.toml")
    assert done.exit_code == 0, done.output
    assert "torque joint2.e" in done.output
    assert "joint2.asymmetric_coulomb.coulomb" in load_robot(tmp_path / "new.toml").parameters
    done = add("torque_ripple", 1, tmp_path / "no.toml")
    assert done.exit_code == 1
    assert "is refused" in done.output
    assert not (tmp_path / "no.toml").exists()
    done = add("teleport", 2, tmp_path / "no.toml")
    assert done.exit_code == 2
    assert "unknown effect 'teleport'" in done.stderr


def test_a_description_is_named_as_the_robot_file_names_it(folder, logs, tmp_path):
    save_robot(two_link(), tmp_path / "old.toml")
    write_log(logs[0], tmp_path / "log.parquet")
    for words, said in (
        (("geometry", "joint2.length"), "is no quantity of a robot's description"),
        (("geometry", "joint2.torque_gain"), "multiply joint2.tau"),
        (("stribeck",), "Give --joint K"),
    ):
        given = ["add", tmp_path / "old.toml", *words, tmp_path / "log.parquet", "-o", tmp_path / "new.toml"]
        done = CliRunner().invoke(main, [str(w) for w in given])
        assert done.exit_code == 2
        assert said in " ".join(done.stderr.split())
        assert not (tmp_path / "new.toml").exists()


def test_a_correction_is_what_the_file_lacks():
    robot = two_link()
    right = corrected(robot, 2, "origin[z]", 0.002)
    assert right.joints[1].origin == pytest.approx((0.0, -0.05, 0.402))
    assert value_of(right, 2, "origin[z]") == "[0, -0.05, 0.402]"
    turned = corrected(robot, 1, "encoder_zero", 0.01)
    assert turned.joints[0].x == pytest.approx(robot.joints[0].x)
    assert turned.joints[1].origin != pytest.approx(robot.joints[1].origin)
    require_new(robot, 2, "axis[y]")
    with pytest.raises(RobotError, match="has no joint 3"):
        require_new(robot, 3, "encoder_zero")
    with pytest.raises(RobotError, match="part of link 2 wherever all logs have it"):
        require_new(robot, 2, "payload")


@pytest.mark.parametrize(("share", "said"), [(0.7, ""), (1.05, ""), (4.57, "its share of 4.57 is above 1")])
def test_a_coefficient_that_the_law_may_not_have_is_said(share, said):
    robot = two_link().with_effect(1, "torque_saturation")
    values = {"joint1.torque_saturation.share": share, "joint1.torque_saturation.limit": 40.0}
    assert extension._no_such_law(robot.with_parameters(values), 1, "torque_saturation") == said
