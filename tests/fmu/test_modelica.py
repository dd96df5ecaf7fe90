"""The Modelica text, compiled by rumoca and parsed by pymoca, beside the FMU."""

from dataclasses import replace

import numpy as np
import pytest

import pyident as pi
from flexfmu.code.modelica import export_modelica, modelica_text
from flexmodels.compiling.compiler import BuildError
from flexmodels.experiment import Experiment
from flexmodels.settings.controller import Controller
from flexmodels.settings.settings import Settings

PERIOD = 0.004


def first_joints(robot, n):
    """An arm of the first joints, with the tip half a metre out."""
    c = robot.controller
    controller = Controller(c.rate, c.Kp[:n], c.Kd[:n], c.Ki[:n])
    return replace(
        robot,
        name="arm",
        joints=robot.joints[:n],
        links=robot.links[:n],
        controller=controller,
        tip=(0.1, 0.0, 0.5),
        settings=Settings(),
    )


def compiled(robot, folder):
    rumoca = pytest.importorskip("rumoca")
    path = export_modelica(robot, folder / "arm.mo")
    return rumoca, rumoca.Session().load(str(path), model=f"{robot.name}.Run")


def run(robot, folder, duration):
    """Tip by the Modelica text and by the FMU at every sample, (N, 3) each; both swing as in `Run`."""
    rumoca, model = compiled(robot, folder)
    # the compiler's own check of its interpolation compares with rtol and fails by chance at a strict one
    config = rumoca.SimConfig(rtol=1e-4, atol=1e-10)
    frame = model.simulate(t=(0, duration), dt=PERIOD, config=config).to_dataframe()
    time = PERIOD * np.arange(round(duration / PERIOD) + 1)
    n = len(robot.joints)
    reference = np.array([0.2 / (1 + k) for k in range(n)]) * (1 - np.cos(np.pi * time))[:, None] / 2
    log = pi.simulate(robot, Experiment(time=time, reference=reference, feedforward=np.zeros_like(reference)))
    last = np.searchsorted(frame.index.to_numpy(), time + 1e-9) - 1
    text = frame[[f"arm.tip[{i}]" for i in (1, 2, 3)]].to_numpy()[last]
    return text, log.frame[["tip.x", "tip.y", "tip.z"]].to_numpy()


def test_one_flexible_joint_moves_alike_for_two_seconds(four_link, tmp_path):
    """Out and back: the friction sticks at the start and at the turn; sampled PID, static equilibrium."""
    text, fmu = run(first_joints(four_link, 1), tmp_path, 2.0)
    assert np.ptp(fmu, axis=0).max() > 0.01
    assert np.abs(text - fmu).max() < 1e-6


def test_the_whole_arm_moves_alike(four_link, tmp_path):
    """Four flexible joints, 16 coordinates; the first stretch of the motion."""
    text, fmu = run(four_link, tmp_path, 0.2)
    assert np.ptp(fmu, axis=0).max() > 0.01
    assert np.abs(text - fmu).max() < 1e-8


@pytest.mark.slow
def test_the_whole_arm_moves_alike_for_two_seconds(four_link, tmp_path):
    """Out and back, with the friction's turns."""
    text, fmu = run(four_link, tmp_path, 2.0)
    assert np.ptp(fmu, axis=0).max() > 0.1
    assert np.abs(text - fmu).max() < 1e-6


def test_a_second_parser_reads_every_robot_that_can_be_written(four_link):
    parser = pytest.importorskip("pymoca.parser")
    tree = parser.parse(modelica_text(four_link))
    package = tree.classes["four_link"]
    assert {"MotorHinge", "FlexibleHinge", "Friction", "Link", "Pid", "Arm", "Run"} <= set(package.classes)
    assert {"joint1", "hinge1", "link4", "controller4"} <= set(package.classes["Arm"].symbols)


def test_what_the_text_does_not_describe_is_refused(four_link):
    joint = four_link.joints[0]
    law = {"stribeck": {"coulomb": 3.0, "velocity": 0.1}}
    hidden = replace(
        four_link, joints=(replace(joint, values={**joint.values, **law}), *four_link.joints[1:])
    )
    with pytest.raises(BuildError, match="stribeck"):
        modelica_text(hidden)
    with pytest.raises(BuildError, match="linkage"):
        modelica_text(pi.load_robot("parallelogram"))
    with pytest.raises(BuildError, match="controller"):
        modelica_text(pi.load_robot("emps"))
