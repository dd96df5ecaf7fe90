"""Plant and controller as two FMUs: together they are the arm with its controller inside."""

import zipfile
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy import calloc, extract, free, read_model_description
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.ssp.ssd import read_ssd
from fmpy.validation import validate_fmu

from flexfmu.simulate import LoadedFmu
from flexfmu.ssp import export_ssp
from flexmodels.experiment import Experiment, identification
from flexmodels.mechanics.plant import equations
from pyident.cli.main import main

PERIOD = 0.004
TIP = ["tip.x", "tip.y", "tip.z"]
JOINTS = range(1, 5)
MOTION = ("e", "de")
LAW = ("tau", "e_sampled", "de_sampled", "stiffness", "damping", "tau_rate")


def of(*signals):
    return [f"joint{k}.{signal}" for signal in signals for k in JOINTS]


def law():
    return [*of(*LAW), "controller.sampled"]


@pytest.fixture(scope="module")
def ssp(four_link, tmp_path_factory):
    return export_ssp(equations(four_link), tmp_path_factory.mktemp("ssp") / "arm.ssp")


@pytest.fixture(scope="module")
def parts(ssp, tmp_path_factory):
    """The two FMUs by name."""
    folder = tmp_path_factory.mktemp("parts")
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder)
    return {name: folder / "resources" / f"{name}.fmu" for name in ("plant", "controller")}


@pytest.fixture(scope="module")
def plan():
    """Half a second that begins smoothly: FMPy's first step knows no inputs."""
    time = np.arange(126) * PERIOD
    turn = np.outer(1 - np.cos(4 * np.pi * time), [0.2, 0.15, 0.1, 0.1])
    return Experiment(time, turn, np.outer(np.sin(12 * np.pi * time), [40.0, 40.0, 20.0, 10.0]))


@pytest.fixture(scope="module")
def together(four_link_fmu, plan):
    """Tip of the single FMU."""
    with LoadedFmu(four_link_fmu) as fmu:
        return fmu.simulate(plan)[TIP].to_numpy()


def silent() -> fmi2CallbackFunctions:
    """Callbacks of its own: FMPy's are one for all FMUs, and call the logger of its last simulation."""
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(lambda *_: None)
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    return callbacks


class Part:
    """One FMU in initialisation mode."""

    def __init__(self, path):
        description = read_model_description(str(path))
        assert description.coSimulation is not None
        self.vr = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(extract(str(path))),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="part",
        )
        self.fmu.instantiate(callbacks=silent())
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()

    def set(self, names, values):
        self.fmu.setReal([self.vr[name] for name in names], [float(v) for v in values])

    def get(self, names):
        return np.array(self.fmu.getReal([self.vr[name] for name in names]))


def coupled(parts, plan, steps):
    """Tip at the samples; `steps` communication steps per sample, the controller before the plant."""
    plant, controller = (Part(parts[name]) for name in ("plant", "controller"))
    plant.set(of("e_0"), plan.reference[0])
    controller.set(of("I_0"), plant.get(of("tau_0")))

    def exchange(i):
        controller.set(of(*MOTION), plant.get(of(*MOTION)))
        controller.set(of("r", "tau_ff"), [*plan.reference[i], *plan.feedforward[i]])

    exchange(0)
    plant.set(law(), controller.get(law()))  # answers at once: direct feed-through
    for part in (plant, controller):
        part.fmu.exitInitializationMode()
    tip, h = [plant.get(TIP)], PERIOD / steps
    for i in range(len(plan.time) - 1):
        for j in range(steps):
            exchange(i)
            controller.fmu.doStep(i * PERIOD + j * h, h)
            plant.set(law(), controller.get(law()))
            plant.fmu.doStep(i * PERIOD + j * h, h)
        tip.append(plant.get(TIP))
    for part in (plant, controller):
        part.fmu.freeInstance()
    return np.array(tip)


@pytest.mark.parametrize("steps", [1, 2, 8])
def test_controller_first_is_exactly_the_single_fmu(parts, plan, together, steps):
    """Steps that the solver divides alike: equal to rounding."""
    assert np.ptp(together, axis=0).min() > 0.1
    np.testing.assert_allclose(coupled(parts, plan, steps), together, rtol=0, atol=1e-11)


def test_the_start_may_be_anywhere(parts, four_link_fmu):
    """The plant says what holds it; the controller starts with that and nothing moves."""
    time = np.arange(51) * PERIOD
    pose = np.tile([0.3, 1.0, -0.7, 0.4], (51, 1))
    plan = Experiment(time, pose, 0 * pose)
    tip = coupled(parts, plan, 1)
    assert np.abs(tip - tip[0]).max() < 1e-12
    with LoadedFmu(four_link_fmu) as fmu:
        np.testing.assert_allclose(tip, fmu.simulate(plan)[TIP], atol=1e-12)


def parallel(parts, plan, steps, handed=None):
    """Tip at the samples under a Jacobi master: both parts step with the values from before the step."""
    plant, controller = (Part(parts[name]) for name in ("plant", "controller"))
    handed = law() if handed is None else handed
    plant.set(of("tau"), controller.get(of("I_0")))
    for part in (plant, controller):
        part.fmu.exitInitializationMode()
    tip, h, received = [plant.get(TIP)], PERIOD / steps, controller.get(handed)
    for i in range(len(plan.time) - 1):
        for j in range(steps):
            controller.set(of(*MOTION), plant.get(of(*MOTION)))
            controller.set(of("r", "tau_ff"), [*plan.reference[i], *plan.feedforward[i]])
            plant.set(handed, received)
            for part in (controller, plant):
                part.fmu.doStep(i * PERIOD + j * h, h)
            received = controller.get(handed)
        tip.append(plant.get(TIP))
    for part in (plant, controller):
        part.fmu.freeInstance()
    return np.array(tip)


def test_a_parallel_master_is_late_by_one_communication_step(parts, plan, together):
    """Of the references: the error falls with the step."""
    error = {n: np.abs(parallel(parts, plan, n) - together).max() for n in (1, 2, 4, 8)}
    assert error[1] < 3e-3  # [m] at 4 ms; the tip moves by 0.4 m
    for n in (1, 2, 4):
        assert 1.6 < error[n] / error[2 * n] < 2.4


def test_the_law_keeps_a_parallel_master_stable(parts, four_link, four_link_fmu):
    """The whole experiment at 4 ms, in which a torque without its law diverges."""
    plan = identification(four_link, duration=2.0)
    with LoadedFmu(four_link_fmu) as fmu:
        expected = fmu.simulate(plan)[TIP].to_numpy()
    assert np.ptp(expected, axis=0).max() > 1.0
    assert np.abs(parallel(parts, plan, 1) - expected).max() < 3e-3
    with pytest.raises(Exception, match="fmi2DoStep failed"):
        parallel(parts, plan, 1, handed=of("tau"))


def test_a_drive_takes_a_law_where_it_arrives_and_holds_it(parts):
    """The torque of joint 1 by the law's own formula; that of the others is held meanwhile."""
    plant = Part(parts["plant"])
    plant.set(of("tau"), plant.get(of("tau_0")) + np.eye(4)[0] * 80.0)
    plant.fmu.exitInitializationMode()
    plant.fmu.doStep(0.0, 0.02)
    before, (e, de) = plant.get(of("tau_motor")), plant.get(["joint1.e", "joint1.de"])
    assert e > 1e-3
    values = [50.0, e - 1e-3, de + 0.02, 4000.0, 30.0, 100.0, 0.015]
    plant.set([*(f"joint1.{name}" for name in LAW), "controller.sampled"], values)
    after = plant.get(of("tau_motor"))
    np.testing.assert_allclose(after[0], 50.0 - 4000.0 * 1e-3 + 30.0 * 0.02 + 100.0 * 0.005, rtol=1e-9)
    plant.fmu.doStep(0.02, 0.004)
    np.testing.assert_array_equal(plant.get(of("tau_motor")), after)
    np.testing.assert_array_equal(after[1:], before[1:])
    plant.set(["joint1.tau"], [51.0])
    assert plant.get(["joint1.tau_motor"])[0] != after[0]
    plant.set(["joint1.tau"], [50.0])  # what it holds already
    np.testing.assert_array_equal(plant.get(of("tau_motor")), after)


def test_a_limited_controller_tells_no_stiffness(parts):
    controller = Part(parts["controller"])
    controller.set(["joint1.tau_max"], [5.0])
    controller.set(of("e"), [0.1] * 4)
    controller.fmu.exitInitializationMode()
    controller.fmu.doStep(0.0, PERIOD)
    assert abs(controller.get(["joint1.tau"])[0]) == 5.0
    told = controller.get(of("stiffness", "damping"))
    assert told[0] == told[4] == controller.get(["joint1.tau_rate"])[0] == 0
    np.testing.assert_array_equal(told[5:], controller.get(of("Kd"))[1:])
    np.testing.assert_array_equal(controller.get(of("e_sampled")), [0.1] * 4)


def test_the_structure_obeys_the_schema(ssp, parts):
    """FMPy validates against SSP's schema on reading; every connector is a variable of its FMU."""
    system = read_ssd(str(ssp)).system
    assert system is not None
    for component in system.elements:
        description = read_model_description(str(parts[component.name]))
        kinds = {v.name: v.causality for v in description.modelVariables}
        assert {c.name: c.kind for c in component.connectors}.items() <= kinds.items()
        assert {c.kind for c in component.connectors} == {"input", "output"}
    assert not system.connectors
    ends = {(c.startElement, c.endElement, c.endConnector) for c in system.connections}
    assert ends == {("plant", "controller", name) for name in of(*MOTION)} | {
        ("controller", "plant", name) for name in law()
    }
    root = ET.fromstring(zipfile.ZipFile(ssp).read("SystemStructure.ssd"))
    assert root.attrib["version"] == "1.0"


def test_both_fmus_are_valid(parts):
    for path in parts.values():
        assert validate_fmu(str(path)) == []


def test_wrong_values_are_refused(parts):
    plant, controller = (Part(parts[name]) for name in ("plant", "controller"))
    for part, name in ((plant, "joint1.tau_0"), (plant, "joint1.e"), (controller, "joint1.tau")):
        with pytest.raises(Exception, match="status"):
            part.set([name], [1.0])
    plant.fmu.exitInitializationMode()
    with pytest.raises(Exception, match="status"):
        plant.set(["joint1.e_0"], [0.2])
    plant.set(["joint1.e_0"], [0.0])  # what it is already
    plant.set(["joint1.tau"], [3.0])


def test_the_command_line_writes_it(tmp_path):
    done = CliRunner().invoke(main, ["export", "four_link", "-o", str(tmp_path / "x.ssp"), "--fmi", "3"])
    assert done.exit_code == 2
    assert "FMI 2" in done.output
    assert not (tmp_path / "x.ssp").exists()
    done = CliRunner().invoke(main, ["export", "four_link", "-o", str(tmp_path / "x.ssp")])
    assert done.exit_code == 0, done.output
    assert "resources/plant.fmu" in zipfile.ZipFile(tmp_path / "x.ssp").namelist()
