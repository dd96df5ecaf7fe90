"""Plant and controller as two FMUs: together they are the arm with its controller inside."""

import zipfile
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.ssd import read_ssd
from fmpy.validation import validate_fmu

from flexfmu.simulate import LoadedFmu
from flexfmu.ssp import export_ssp
from flexmodels.experiment import Experiment
from flexmodels.mechanics.plant import equations
from pyident.cli.main import main

PERIOD = 0.004
TIP = ["tip.x", "tip.y", "tip.z"]
JOINTS = range(1, 5)


def of(signal):
    return [f"joint{k}.{signal}" for k in JOINTS]


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
        self.fmu.instantiate()
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
        controller.set(of("e"), plant.get(of("e")))
        controller.set([*of("r"), *of("tau_ff")], [*plan.reference[i], *plan.feedforward[i]])

    exchange(0)
    plant.set(of("tau"), controller.get(of("tau")))  # answers at once: direct feed-through
    for part in (plant, controller):
        part.fmu.exitInitializationMode()
    tip, h = [plant.get(TIP)], PERIOD / steps
    for i in range(len(plan.time) - 1):
        for j in range(steps):
            exchange(i)
            controller.fmu.doStep(i * PERIOD + j * h, h)
            plant.set(of("tau"), controller.get(of("tau")))
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


def parallel(parts, plan, steps):
    """Tip at the samples under a Jacobi master: both parts step with the values from before the step."""
    plant, controller = (Part(parts[name]) for name in ("plant", "controller"))
    for part in (plant, controller):
        part.fmu.exitInitializationMode()
    tip, h, tau = [plant.get(TIP)], PERIOD / steps, controller.get(of("I_0"))
    for i in range(len(plan.time) - 1):
        for j in range(steps):
            controller.set(of("e"), plant.get(of("e")))
            controller.set([*of("r"), *of("tau_ff")], [*plan.reference[i], *plan.feedforward[i]])
            plant.set(of("tau"), tau)
            for part in (controller, plant):
                part.fmu.doStep(i * PERIOD + j * h, h)
            tau = controller.get(of("tau"))
        tip.append(plant.get(TIP))
    return np.array(tip)


def test_a_parallel_master_is_late_by_one_communication_step(parts, plan, together):
    """Stable at the controller's own period; the error falls with the step."""
    error = {n: np.abs(parallel(parts, plan, n) - together).max() for n in (1, 8, 16, 32)}
    assert error[1] < 0.01  # [m] at 4 ms; the tip moves by 0.4 m
    assert 1.7 < error[8] / error[16] < 2.3
    assert 1.7 < error[16] / error[32] < 2.3
    assert error[32] < 3e-4


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
    assert ends == {("plant", "controller", name) for name in of("e")} | {
        ("controller", "plant", name) for name in of("tau")
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
