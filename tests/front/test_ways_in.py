"""How models and logs may be given to the verbs, and what is refused in one sentence."""

import numpy as np
import pandas as pd
import pytest
from one_joint import one_joint, swing
from two_link_logs import two_link

import pyident as pi
from flexmodels.compiling.compiler import BuildError
from flexmodels.robot import RobotError
from pyident.logs.disk import log_file
from pyident.logs.log import LogError, write_log
from pyident.logs.mapping import read_mapping
from pyident.sweep.store import StudyError
from pyident.verbs.inputs import given, opened, read_logs


@pytest.fixture(scope="module")
def log():
    return pi.simulate(one_joint(), swing(4.0))


@pytest.fixture(scope="module")
def folder(log, tmp_path_factory):
    """A log under our names, the same in degrees under others, and a mapping that tells them."""
    folder = tmp_path_factory.mktemp("logs")
    write_log(log, folder / "a.parquet")
    frame = log.frame
    foreign = pd.DataFrame(
        {
            "t": frame["time"],
            "angle": np.degrees(frame["joint1.e"]),
            "effort": frame["joint1.tau"],
            "wish": frame["joint1.r"],
        }
    )
    foreign.to_csv(folder / "foreign.csv", index=False)
    (folder / "mapping.toml").write_text(
        'joints = 1\ntime = { source = "t", unit = "s" }\n'
        '[signals."joint1.e"]\nsource = "angle"\nunit = "deg"\n'
        '[signals."joint1.tau"]\nsource = "effort"\nunit = "N.m"\n'
        '[signals."joint1.r"]\nsource = "wish"\nunit = "rad"\n'
    )
    return folder


def test_every_way_to_give_a_log_is_the_same_log(log, folder):
    mapping = folder / "mapping.toml"
    foreign = pd.read_csv(folder / "foreign.csv")
    ways = [
        given(one_joint(), log).logs[0],
        given(one_joint(), [log.frame]).logs[0],
        given(one_joint(), folder / "a.parquet").logs[0],
        given(one_joint(), log_file(folder / "a.parquet")).logs[0],
        given(one_joint(), folder / "foreign.csv", mapping).logs[0],
        given(one_joint(), foreign, read_mapping(mapping)).logs[0],
        given(one_joint(), log, mapping).logs[0],  # it has our names already
        read_logs(one_joint(), log_file(folder / "a.parquet"), None)[0],
        pi.read_log(folder / "foreign.csv", one_joint(), mapping),
        pi.read_log(folder / "foreign.csv", mapping=mapping),
        pi.read_log(folder / "a.parquet"),
    ]
    for way in ways:
        for name in ("joint1.e", "joint1.tau"):
            np.testing.assert_allclose(way.frame[name], log.frame[name], rtol=1e-9, atol=1e-12)


def test_what_logs_share_is_noted_once(folder):
    asking = folder / "asking.toml"
    asking.write_text(f"# ? which way\n{(folder / 'mapping.toml').read_text()}")
    notes = given(one_joint(), [folder / "foreign.csv"] * 2, asking).notes
    assert [note.split(" (")[0] for note in notes] == ["the mapping still asks a question"]


def test_a_log_on_disk_stays_there(folder):
    file = log_file(folder / "a.parquet")
    assert opened(one_joint(), [file]).logs[0] is file
    for verb in (given, opened):
        with pytest.raises(LogError, match="there is no log; give one or more"):
            verb(one_joint(), [])


def test_a_fit_goes_on_from_the_prior(log):
    """What the log leaves open stays near the prior; what it tells does not change."""
    prior = one_joint().with_parameters({"link1.m": 3.0})
    noise = np.random.default_rng(1).normal(0, (1e-5, 1e-2), (len(log.frame), 2))
    noisy = log.frame.copy()
    noisy[["joint1.e", "joint1.tau"]] += noise
    plain, near = pi.identify(one_joint(), noisy), pi.identify(one_joint(), noisy, prior=prior)
    assert near.robot.parameters["link1.m"] == pytest.approx(3.0, rel=0.05)
    for name, truth in (("joint1.coulomb", 1.0), ("joint1.viscous", 2.0)):
        assert plain.robot.parameters[name] == pytest.approx(truth, rel=0.03)
        assert near.robot.parameters[name] == pytest.approx(truth, rel=0.03)


def test_what_cannot_be_is_refused(log, folder, tmp_path):
    with pytest.raises(RobotError, match="there is no estimator best; there are ols, wls"):
        pi.identify(one_joint(), log, estimator="best")
    with pytest.raises(RobotError, match=r"robot one_joint has no \[servo\]; describe its drives"):
        pi.identify_servo(one_joint(), log)
    with pytest.raises(StudyError, match="a design needs its model and its experiment"):
        pi.parameter_study(pd.DataFrame({"joint1.coulomb": [1.0]}), tmp_path / "out")
    with pytest.raises(BuildError, match=r"an SSP holds plant and controller; name it \.fmu for the plant"):
        pi.export_fmu(one_joint(), tmp_path / "arm.ssp", part="plant")
    with pytest.raises(BuildError, match="Modelica text holds the arm with its controller, not the plant"):
        pi.export_fmu(one_joint(), tmp_path / "arm.mo", part="plant")
    with pytest.raises(BuildError, match=r"SSP 1\.0 holds FMUs of FMI 2\.0; leave out --fmi 3"):
        pi.export_fmu(one_joint(), tmp_path / "arm.ssp", fmi=3)
    with pytest.raises(RobotError, match="a mapping needs a robot file; import the log first"):
        pi.simulate(tmp_path / "arm.fmu", "line", mapping=folder / "mapping.toml")
    assert not list(tmp_path.glob("*"))


def test_a_robot_becomes_modelica_text(tmp_path):
    text = pi.export_fmu(two_link(), tmp_path / "two_link.mo").read_text("utf-8")
    assert text.startswith("package two_link ")
    assert text.rstrip().endswith("end two_link;")
