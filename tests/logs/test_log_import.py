"""Recordings of other tools: names, units, sides and clocks."""

import json
from dataclasses import replace
from importlib import resources

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from scipy.io import savemat

from flexmodels.files.robot_file import load_robot, save_robot
from flexmodels.gearing import Transmission
from pyident.checks.encoder_delay import encoder_skews, without_skew
from pyident.cli.main import main
from pyident.estimation.lock_unlogged import locked
from pyident.logs import datasets as data_sets
from pyident.logs.foreign import at_joints, delayed, import_log
from pyident.logs.log import Log, LogError, read_log, write_log
from pyident.logs.mapping import read_mapping


def mapping(folder, text):
    file = folder / "mapping.toml"
    file.write_text(text)
    return read_mapping(file)


def test_a_shipped_mapping_is_read_by_its_name():
    file = resources.files("pyident.logs") / "mappings" / "tx40.toml"
    assert read_mapping("tx40") == read_mapping(str(file))
    with pytest.raises(LogError, match=r"no mapping file tx41; .* emps, kuka_kr300, tx40"):
        read_mapping("tx41")


def test_units_signs_offsets_and_several_files(tmp_path):
    pd.DataFrame({"ms": [0, 4, 8, 12], "a": [1.0, 2, 3, 4]}).to_csv(tmp_path / "one.csv", index=False)
    pd.DataFrame({"a": [10.0, 20, 30, 40]}).to_csv(tmp_path / "two.csv", index=False)
    m = mapping(
        tmp_path,
        'time = {source = "ms", unit = "ms"}\n[signals."joint1.e"]\nsource = "one:a"\nunit = "deg"\n'
        'sign = -1\noffset = 90\n[signals."joint1.tau"]\nsource = "two:a"\nunit = "mNm"\ngain = 2\n',
    )
    log = import_log([tmp_path / "one.csv", tmp_path / "two.csv"], m)
    np.testing.assert_allclose(log.frame["joint1.e"], np.radians([89, 88, 87, 86]))
    np.testing.assert_allclose(log.frame["joint1.tau"], [0.02, 0.04, 0.06, 0.08])
    assert log.period == pytest.approx(0.004)


def test_a_link_that_turns_against_its_motor_is_refused():
    motor = np.sin(np.arange(100) / 10)
    frame = pd.DataFrame({"joint1.e": motor, "joint1.link": motor + 1e-3 * np.cos(np.arange(100))})
    robot = replace(load_robot("emps"), controller=None)
    assert np.ptp(at_joints(frame, robot, "log")["joint1.eps[1]"]) == pytest.approx(2e-3, rel=0.01)
    with pytest.raises(LogError, match=r"link of joint 1 turns against its motor.*sign = -1"):
        at_joints(frame.assign(**{"joint1.link": -frame["joint1.link"]}), robot, "log")


def test_open_questions_of_a_mapping_are_said(tmp_path):
    """`log inspect` writes each twice: at the top and where it belongs."""
    np.savetxt(tmp_path / "raw.csv", np.arange(8.0).reshape(4, 2), delimiter=",")
    text = 'rate = 10\nheader = false\n{}[signals."joint1.e"]\nsource = "1"\n'
    for asked, said in (("", 0), ("# ? how fast?\n# ? a unit?\n# ? a unit?\n", 2)):
        notes = import_log([tmp_path / "raw.csv"], mapping(tmp_path, text.format(asked))).notes
        assert [f"asks {said} questions" in note for note in notes] == [True] * bool(said)


def test_no_header_and_structs(tmp_path):
    np.savetxt(tmp_path / "raw.csv", np.arange(12.0).reshape(4, 3), delimiter=",")
    m = mapping(
        tmp_path,
        'rate = 10\nheader = false\njoints = 2\n[signals."joint{k}.e"]\nsource = "{k}"\nsign = [1, -1]',
    )
    log = import_log([tmp_path / "raw.csv"], m)
    assert log.frame["joint2.e"].tolist() == [-1.0, -4.0, -7.0, -10.0]
    savemat(tmp_path / "raw.mat", {"rec": {"deg": np.arange(12.0).reshape(2, 6), "note": "x"}})
    m = mapping(tmp_path, 'rate = 10\njoints = 2\n[signals."joint{k}.e"]\nsource = "rec.deg[{k}]"')
    assert import_log([tmp_path / "raw.mat"], m).frame["joint2.e"].tolist() == [6.0, 7, 8, 9, 10, 11]


def test_uneven_time_is_resampled_and_said(tmp_path):
    rng = np.random.default_rng(0)
    time = np.arange(500) * 0.01 + rng.uniform(-0.002, 0.002, 500)
    pd.DataFrame({"t": time, "x": np.sin(time)}).to_csv(tmp_path / "raw.csv", index=False)
    m = mapping(tmp_path, 'time = {source = "t"}\n[signals."joint1.e"]\nsource = "x"')
    log = import_log([tmp_path / "raw.csv"], m)
    np.testing.assert_allclose(log.frame["joint1.e"], np.sin(log.frame["time"]), atol=1e-6)
    assert "time was uneven" in log.notes[0]


def test_motor_side_through_the_transmission(four_link):
    rng = np.random.default_rng(1)
    R = np.diag([100.0, -90, 80, 70])
    R[3, 2] = 35
    gear = Transmission(tuple(map(tuple, R)), (0.1, 0.2, 0.3, 0.4), (2.0, 2.0, 3.0, 3.0))
    robot = replace(four_link, transmission=gear)
    q, current = rng.normal(size=(5, 4)), rng.normal(size=(5, 4))
    motors = (q - np.array(gear.offset)) @ R.T
    columns = {f"motor{k + 1}.q": motors[:, k] for k in range(4)}
    columns |= {f"motor{k + 1}.current": current[:, k] for k in range(4)}
    frame = at_joints(pd.DataFrame(columns), robot, "log")
    np.testing.assert_allclose(frame[[f"joint{k}.e" for k in (1, 2, 3, 4)]], q)
    torque = frame[[f"joint{k}.tau" for k in (1, 2, 3, 4)]].to_numpy()
    speed = rng.normal(size=4)  # power is the same on both sides
    np.testing.assert_allclose(torque @ speed, (current * [2, 2, 3, 3]) @ (R @ speed))
    with pytest.raises(LogError, match=r"give the robot a \[transmission\]"):
        at_joints(pd.DataFrame(columns), four_link, "log")
    with pytest.raises(LogError, match=r"motor4\.q is missing"):
        at_joints(pd.DataFrame(columns).drop(columns="motor4.q"), robot, "log")


@pytest.mark.parametrize("ratio", [[[2.0, 0, 0, 0], [0, 3, 0, 0], [0, 0, 4, 0], [0, 0, 1, 5]], None])
def test_a_robot_file_keeps_its_transmission(ratio, four_link, tmp_path):
    gear = Transmission(tuple(map(tuple, ratio or np.eye(4).tolist())), (0.0, 1.0, 0.0, 0.0))
    robot = replace(four_link, transmission=gear)
    save_robot(robot, tmp_path / "robot.toml")
    assert load_robot(tmp_path / "robot.toml").transmission == gear


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[signals]", "give either rate"),
        ('rate = 1\n[signals."joint1.e"]\nsource = "x"\nunit = "furlong"', "'furlong' is not a known unit"),
        ('rate = 1\n[signals."joint1.e"]\nsource = "y"', "there is no column y; there are x"),
        ('rate = 1\n[signals."joint1.e"]\nsource = "x"\ncolour = 1', "colour is not a known key"),
    ],
)
def test_wrong_mappings_are_explained(text, words, tmp_path):
    pd.DataFrame({"x": [1.0, 2, 3, 4]}).to_csv(tmp_path / "raw.csv", index=False)
    with pytest.raises(LogError, match=words) as caught:
        import_log([tmp_path / "raw.csv"], mapping(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_a_log_of_one_row_and_columns_that_another_name_repeats_are_told_plainly(tmp_path, recwarn):
    rows = pd.DataFrame({"t": [0.1], "x": [1.0]})
    rows.to_csv(tmp_path / "raw.csv", index=False)
    text = 'time = { source = "t" }\n[signals."joint1.e"]\nsource = "x"'
    with pytest.raises(LogError, match="it has 1 row, too few for any motion"):
        import_log([tmp_path / "raw.csv"], mapping(tmp_path, text))
    rows.drop(columns="x").assign(y=2.0).to_csv(tmp_path / "raw.csv", index=False)
    with pytest.raises(LogError, match=r"there is no column x; there are t, y$"):
        import_log([tmp_path / "raw.csv"], mapping(tmp_path, text))
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]


def test_a_skew_that_was_put_in_is_found_and_taken_out(four_link, identification_log):
    joints = tuple(replace(j, bends=False, values=_twist(j.values)) for j in four_link.joints)
    robot = replace(four_link, joints=joints)
    frame = identification_log.frame
    link = frame.assign(**{"joint2.eps[1]": frame["joint2.eps[1]"] + frame["joint2.e"]})
    late = delayed(link, {"joint2.eps[1]": -0.0015})["joint2.eps[1]"] - frame["joint2.e"]
    log = Log(frame.assign(**{"joint2.eps[1]": late}), "late")
    before = {s.joint: s.delay for s in encoder_skews(robot, Log(frame, "right"))}
    skews = {s.joint: s for s in encoder_skews(robot, log)}
    assert skews[2].delay - before[2] == pytest.approx(0.0015, rel=0.05)
    mended, notes = without_skew(log, [replace(skews[2], delay=0.0015)])
    assert "corrected" in notes[0]
    wrong = (mended.frame["joint2.eps[1]"] - frame["joint2.eps[1]"])[10:-10].abs().max()
    assert wrong < 0.02 * (late - frame["joint2.eps[1]"]).abs().max()


def _twist(values):
    return {law: {n: v for n, v in p.items() if n[1:] not in ("[2]", "[3]")} for law, p in values.items()}


def test_a_logged_twist_of_a_joint_that_is_rigid_in_the_robot_file_is_said(identification_log, four_link):
    rigid, _ = locked(four_link, [Log(identification_log.frame.drop(columns="joint2.eps[1]"), "bare")])
    robot, notes = locked(rigid, [identification_log])
    assert robot == rigid
    assert [note.partition(" is ")[0] for note in notes] == ["joint 2: joint2.eps[1]"]


def test_hinges_without_a_log_are_locked_and_it_is_said(identification_log, four_link, tmp_path):
    columns = ["joint2.eps[1]", "joint2.eps[2]", "joint2.eps[3]", "joint3.eps[2]", "joint3.eps[3]"]
    log = Log(identification_log.frame.drop(columns=columns).head(400), "bare")
    robot, notes = locked(four_link, [log])
    assert [j.deformations for j in robot.joints] == [(1, 2, 3), (), (1,), (1, 2, 3)]
    assert ("stiffness and damping cannot be told" in notes[0], "only twists" in notes[1]) == (True, True)
    write_log(log, tmp_path / "log.csv")
    words = ["identify", "four_link", tmp_path / "log.csv", "--json", tmp_path / "r.json"]
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    assert "note: joint 2: no link-side encoder" in done.output
    notes = json.loads((tmp_path / "r.json").read_text())["notes"]
    assert sum("locked" in note or "only twists" in note for note in notes) == 2


def test_joint_states_of_a_bag(tmp_path):
    rosbags = pytest.importorskip("rosbags.rosbag2", reason="the extra `ros` is not installed")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    State, Header = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Header"]
    Time = store.types["builtin_interfaces/msg/Time"]
    plugin = rosbags.StoragePlugin.MCAP
    with rosbags.Writer(tmp_path / "bag", version=9, storage_plugin=plugin) as writer:
        topic = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for i in range(20):
            header = Header(stamp=Time(sec=5, nanosec=i * 10_000_000), frame_id="")
            x = np.array([0.1 * i, -0.1 * i])
            message = State(header=header, name=["a", "b"], position=x, velocity=x, effort=2 * x)
            writer.write(topic, i, store.serialize_cdr(message, "sensor_msgs/msg/JointState"))
    m = mapping(
        tmp_path,
        'time = {source = "time"}\n[signals."joint1.e"]\nsource = "b.position"\n[signals."joint1.tau"]\n'
        'source = "b.effort"',
    )
    log = import_log([next((tmp_path / "bag").glob("*.mcap"))], m)
    np.testing.assert_allclose(log.frame["joint1.tau"], -0.2 * np.arange(20))
    assert log.period == pytest.approx(0.01)


def test_data_sets(data, monkeypatch, tmp_path):
    assert len(data_sets.fetch("tx40")) == 2
    monkeypatch.setenv("PYIDENT_DATA", str(tmp_path))
    (tmp_path / "emps").mkdir()
    (tmp_path / "emps" / "DATA_EMPS.mat").write_text("something else")
    with pytest.raises(LogError, match="its SHA-256 differs"):
        data_sets.fetch("emps")
    with pytest.raises(LogError, match="there is no data set nothing; there are emps, tx40"):
        data_sets.fetch("nothing")
    assert "tx40" in CliRunner().invoke(main, ["data", "list"]).output


def test_the_import_command(data, tmp_path):
    raw = data / "kuka_kr300" / "A" / "data.mat"
    file = resources.files("pyident.logs") / "mappings" / "kuka_kr300.toml"
    words = [
        "log",
        "import",
        raw,
        "--mapping",
        file,
        "--robot",
        "kuka_kr300",
        "--skew",
        "-o",
        tmp_path / "a.csv",
    ]
    done = CliRunner().invoke(main, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    assert "2501 samples at 250 Hz" in done.output
    assert "joint 3: link encoder 3.0" in done.output
    assert "joint 1" in done.output
    assert "cannot tell" in done.output


def test_columns_that_speak_for_themselves_need_no_mapping(tmp_path):
    """Those of a log are in its units; others must leave no question."""
    time = np.arange(2000) / 250
    jitter = np.random.default_rng(0).uniform(-2e-4, 2e-4, len(time))
    own = pd.DataFrame(
        {"time": time + jitter, "joint1.e": 0.3 * np.sin(time), "joint1.tau": 5.0 * np.cos(time)}
    )
    own.to_csv(tmp_path / "own.csv", index=False)
    words = ["log", "import", str(tmp_path / "own.csv"), "-o", str(tmp_path / "log.parquet")]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    made = read_log(tmp_path / "log.parquet")
    assert made.frame["joint1.e"].to_numpy() == pytest.approx(0.3 * np.sin(made.frame["time"]), abs=1e-4)
    own.rename(columns={"joint1.e": "ActPos_1", "joint1.tau": "current"}).to_csv(
        tmp_path / "raw.csv", index=False
    )
    words[2] = str(tmp_path / "raw.csv")
    refused = CliRunner().invoke(main, [*words, "--overwrite"])
    assert refused.exit_code == 2
    assert "log inspect" in refused.output
    assert "?" in refused.output
