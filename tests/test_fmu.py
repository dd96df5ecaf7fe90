"""The FMU as a citizen: both standards, both kinds, states, derivatives, refusals, energy."""

import ctypes
import io
import zipfile
from typing import Any

import matplotlib.image
import numpy as np
import pandas as pd
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2EventInfo
from fmpy.fmi3 import FMU3Slave, fmi3LogMessageCallback
from fmpy.validation import validate_fmu

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu, _callbacks
from flexfmu.variables import arrays, base_units, states, variables
from flexmodels.experiment import Experiment, identification
from flexmodels.plant import equations

TIP = ["tip.x", "tip.y", "tip.z"]


@pytest.fixture(scope="module")
def fmus(four_link, tmp_path_factory):
    """Both versions, with derivatives."""
    folder, eq = tmp_path_factory.mktemp("fmus"), equations(four_link)
    return {fmi: export_fmu(eq, folder / f"arm{fmi}.fmu", fmi=fmi) for fmi in (2, 3)}


@pytest.fixture(scope="module")
def plan(four_link):
    return identification(four_link, duration=0.5)


class Opened:
    """An instance driven by hand through FMPy's thin layer."""

    def __init__(self, path, kind, reference):
        self.description = read_model_description(str(path))
        assert self.description.coSimulation is not None
        self.vr = {v.name: v.valueReference for v in self.description.modelVariables}
        self.fmu = kind(
            guid=self.description.guid,
            unzipDirectory=str(extract(str(path))),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="arm",
        )
        self.start(reference)

    def start(self, reference):
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.set({f"joint{k + 1}.r": r for k, r in enumerate(reference)})
        self.fmu.exitInitializationMode()

    def set(self, values):
        self.fmu.setReal([self.vr[n] for n in values], list(values.values()))

    def get(self, names):
        return np.array(self.fmu.getReal([self.vr[n] for n in names]))


def test_descriptions_are_valid(fmus):
    for path in fmus.values():
        assert validate_fmu(str(path)) == []


def test_contents_are_complete(fmus):
    for fmi, path in fmus.items():
        names = set(zipfile.ZipFile(path).namelist())
        assert {
            "modelDescription.xml",
            "documentation/index.html",
            "sources/model.c",
            f"sources/fmi{fmi}.c",
        } <= names
    assert {"sources/buildDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml"} <= names


def test_both_standards_agree_to_rounding(fmus, plan):
    logs = {}
    for fmi, path in fmus.items():
        with LoadedFmu(path) as fmu:
            logs[fmi] = fmu.simulate(plan)
    assert list(logs[2]) == list(logs[3])
    difference = (logs[2] - logs[3]).abs().max()
    # 1.2e-12: the inputs, set in one and extrapolated in the other, differ in the last bit: so does an event
    assert difference.drop([c for c in difference.index if c.endswith("tau")]).max() < 1e-11


@pytest.mark.parametrize("fmi", [2, 3])
def test_model_exchange_under_cvode_agrees_with_co_simulation(fmus, plan, fmi):
    from fmpy import simulate_fmu

    names = [f"joint{k}.{s}" for s in ("r", "tau_ff") for k in range(1, 5)]
    signals = np.zeros(len(plan.time), dtype=[(n, float) for n in ("time", *names)])
    signals["time"] = plan.time
    for name, values in zip(names, np.hstack([plan.reference, plan.feedforward]).T, strict=True):
        signals[name] = values
    result = simulate_fmu(
        str(fmus[fmi]),
        fmi_type="ModelExchange",
        stop_time=plan.time[-1],
        output_interval=0.004,
        relative_tolerance=1e-9,
        input=signals,
        output=TIP,
    )
    with LoadedFmu(fmus[2]) as fmu:
        log = fmu.simulate(plan, {"solver.step": 1e-4})
    last = np.searchsorted(result["time"], plan.time + 1e-9) - 1
    tip = np.column_stack([result[n][last] for n in TIP])
    assert np.abs(tip - log[TIP].to_numpy()).max() < 1e-8


def test_rollback_is_bit_identical(fmus):
    opened = Opened(fmus[2], FMU2Slave, [0.1, 0.2, 0.3, 0.4])
    fmu, outputs = opened.fmu, [v.name for v in opened.description.modelVariables]
    opened.set({"joint1.r": 0.2, "joint2.tau_ff": 40.0})
    for i in range(7):
        fmu.doStep(i * 0.003, 0.003)
    state = fmu.getFMUState()
    raw = fmu.serializeFMUState(state)

    def onwards():
        for i in range(20):
            fmu.doStep(0.021 + i * 0.003, 0.003)
        return opened.get(outputs)

    first = onwards()
    fmu.setFMUState(state)
    assert (onwards() == first).all()
    restored = fmu.deserializeFMUState(raw)
    fmu.setFMUState(restored)
    assert (onwards() == first).all()
    for s in (state, restored):
        fmu.freeFMUState(s)
    fmu.freeInstance()


def test_instances_do_not_know_of_each_other(fmus):
    first = Opened(fmus[2], FMU2Slave, [0.1, 0.2, 0.3, 0.4])
    second = Opened(fmus[2], FMU2Slave, [0.1, 0.2, 0.3, 0.4])
    second.set({"joint1.r": 0.5})
    for i in range(10):
        first.fmu.doStep(i * 0.004, 0.004)
        second.fmu.doStep(i * 0.004, 0.004)
    assert first.get(["joint1.e"]) == 0.1
    assert second.get(["joint1.e"]) > 0.1


def test_steps_of_any_length_are_accepted(fmus):
    opened = Opened(fmus[2], FMU2Slave, [0.0] * 4)
    before = opened.get(TIP)
    opened.fmu.doStep(0.0, 0.0)
    assert (opened.get(TIP) == before).all()
    opened.set({"joint1.r": 0.1})
    for t, h in ((0.0, 1e-9), (1e-9, 0.0123456), (0.012345601, 0.7)):
        opened.fmu.doStep(t, h)
    assert opened.get(["joint1.e"]) == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("joint1.k[1]", -1.0),
        ("joint2.J_m", 0.0),
        ("link2.m", -0.1),
        ("joint3.coulomb", float("nan")),
        ("joint1.e", 0.3),
    ],
)
@pytest.mark.parametrize("fmi", [2, 3])
def test_wrong_values_are_refused_with_a_sentence(fmus, fmi, name, value):
    said = []
    opened = OPENED[fmi](fmus[fmi], said)
    vr = opened.vr[name]
    before = opened.read(vr)
    with pytest.raises(Exception, match="status"):
        opened.write(vr, value)
    assert opened.read(vr) == before
    assert len(said) == 1
    assert name in said[0]
    assert said[0].endswith(".")


class Listening2:
    """FMI 2.0 co-simulation in initialisation mode, with what the FMU logs."""

    def __init__(self, path, said):
        description = read_model_description(str(path))
        assert description.coSimulation is not None
        self.vr = {v.name: v.valueReference for v in description.modelVariables}
        self.fmu = self.kind(
            guid=description.guid,
            unzipDirectory=str(extract(str(path))),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName="arm",
        )
        self.begin(said)

    kind: Any = FMU2Slave

    def begin(self, said):
        self.fmu.instantiate(callbacks=_callbacks(said))
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()

    def read(self, vr):
        return self.fmu.getReal([vr])[0]

    def write(self, vr, value):
        self.fmu.setReal([vr], [value])


class Listening3(Listening2):
    """The same in FMI 3.0."""

    kind: Any = FMU3Slave

    def begin(self, said):
        self.keep = fmi3LogMessageCallback(lambda *words: said.append(words[-1].decode()))
        self.fmu.instantiate(logMessage=self.keep)
        self.fmu.enterInitializationMode()

    def read(self, vr):
        return self.fmu.getFloat64([vr])[0]

    def write(self, vr, value):
        self.fmu.setFloat64([vr], [value])


OPENED = {2: Listening2, 3: Listening3}


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("fmi", [2, 3])
def test_a_stuck_arm_under_gravity_stays(fmus, four_link, fmi, interface):
    """60 s, controller gains off, gravity carried by the integral less what dry friction holds."""
    off = {f"joint{k}.{gain}": 0.0 for k in range(1, 5) for gain in ("Kp", "Kd", "Ki")}
    names = [f"joint{k}.e" for k in range(1, 5)]
    pose = {f"joint{k}.r": r for k, r in zip(range(1, 5), (0.0, 1.2, -0.5, 0.0), strict=True)}
    push = {f"joint{k}.tau_ff": t for k, t in zip(range(1, 5), (29.9, -44.9, 17.9, -7.9), strict=True)}
    result = simulate_fmu(
        str(fmus[fmi]),
        fmi_type=interface,
        stop_time=60.0,
        output_interval=0.1,
        start_values=off | pose | push,
        relative_tolerance=1e-8,
        output=names,
    )
    drift = np.column_stack([result[n] for n in names]) - list(pose.values())
    assert np.abs(drift).max() < 1e-9


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_recorded_run_is_reproduced(fmus, fmi):
    """documentation/*_ref.csv by the inputs and options beside it, co-simulation and CVode."""
    with zipfile.ZipFile(fmus[fmi]) as archive:
        table, options, inputs = (
            io.StringIO(archive.read(f"documentation/four_link_{end}").decode())
            for end in ("ref.csv", "ref.opt", "in.csv")
        )
    reference = pd.read_csv(table)
    option = dict(line.split(",") for line in options.read().split())
    signals = pd.read_csv(inputs)
    assert np.ptp(reference["tip.x"]) > 1e-5
    for interface, tolerance in (("CoSimulation", 1e-12), ("ModelExchange", 1e-6)):
        result = simulate_fmu(
            str(fmus[fmi]),
            fmi_type=interface,
            stop_time=float(option["StopTime"]),
            output_interval=float(option["StepSize"]),
            relative_tolerance=float(option["RelTol"]) * 1e-2,
            input=np.array(list(map(tuple, signals.to_numpy())), dtype=[(n, float) for n in signals]),
            output=TIP,
        )
        last = np.searchsorted(result["time"], reference["time"] + 1e-9) - 1
        np.testing.assert_allclose(
            np.column_stack([result[n][last] for n in TIP]), reference[TIP], rtol=0, atol=tolerance
        )


def test_the_icon_is_a_picture(fmus):
    with zipfile.ZipFile(fmus[2]) as two, zipfile.ZipFile(fmus[3]) as three:
        png = two.read("model.png")
        assert png == three.read("terminalsAndIcons/icon.png")
        assert b"<svg" in three.read("terminalsAndIcons/icon.svg")
    assert matplotlib.image.imread(io.BytesIO(png)).shape == (256, 256, 4)


class Exchange(Opened):
    """Model exchange at a moving state with a torque."""

    def __init__(self, path):
        super().__init__(path, FMU2Model, [0.4, 0.9, -0.6, 0.3])
        rng = np.random.default_rng(6)
        info = fmi2EventInfo()
        self.fmu.fmi2NewDiscreteStates(self.fmu.component, ctypes.byref(info))
        self.names = list(states_of(self.description))
        x = np.r_[
            0.4, 0.9, -0.6, 0.3, 1e-3 * rng.normal(size=12), rng.uniform(0.5, 1, 4), 0.1 * rng.normal(size=12)
        ]
        self.put(x)
        self.fmu.fmi2NewDiscreteStates(self.fmu.component, ctypes.byref(info))
        self.set({"joint1.r": 0.5, "joint2.r": 1.0})
        self.put(x)
        self.x = x

    def put(self, x):
        x = np.ascontiguousarray(x)
        self.fmu.fmi2SetContinuousStates(
            self.fmu.component, x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)), 32
        )


def states_of(description):
    return [v.derivative.name for v in description.modelVariables if v.derivative]


def test_directional_derivatives_are_those_of_finite_differences(fmus):
    opened = Exchange(fmus[2])
    opened.fmu.enterContinuousTimeMode()
    known = [*opened.names, "joint1.viscous", "link3.m", "joint2.k[1]"]
    unknown = [*(f"der({n})" for n in opened.names), *TIP]
    steps = {n: 1e-7 for n in opened.names} | {"joint1.viscous": 1e-3, "link3.m": 1e-4, "joint2.k[1]": 1.0}
    for i, name in enumerate(known):
        exact = opened.fmu.getDirectionalDerivative([opened.vr[n] for n in unknown], [opened.vr[name]], [1.0])
        values = []
        for sign in (1, -1):
            if i < 32:
                x = opened.x.copy()
                x[i] += sign * steps[name]
                opened.put(x)
                values.append(opened.get(unknown))
                opened.put(opened.x)
            else:
                start = opened.get([name])[0]
                opened.set({name: start + sign * steps[name]})
                values.append(opened.get(unknown))
                opened.set({name: start})
        numeric = (values[0] - values[1]) / (2 * steps[name])
        np.testing.assert_allclose(exact, numeric, rtol=2e-5, atol=2e-6 * np.abs(numeric).max() + 1e-9)


def test_the_adjoint_is_the_transpose(fmus):
    from fmpy.fmi3 import FMU3Model

    description = read_model_description(str(fmus[3]))
    assert description.modelExchange is not None
    vr = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU3Model(
        guid=description.guid,
        unzipDirectory=str(extract(str(fmus[3]))),
        modelIdentifier=description.modelExchange.modelIdentifier,
        instanceName="arm",
    )
    fmu.instantiate()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.updateDiscreteStates()
    fmu.enterContinuousTimeMode()
    names = states_of(description)
    known = [vr[n] for n in (*names, "joint2.viscous", "link4.m")]
    unknown = [vr[f"der({n})"] for n in names] + [vr[n] for n in TIP]
    rng = np.random.default_rng(1)
    v, w = rng.normal(size=len(known)), rng.normal(size=len(unknown))
    forward = np.zeros(len(unknown))
    backward = np.zeros(len(known))

    def vector(values, kind):
        return (kind * len(values))(*values)

    u32, f64 = ctypes.c_uint32, ctypes.c_double
    jv, wj = vector(forward, f64), vector(backward, f64)
    a, b = vector(unknown, u32), vector(known, u32)
    fmu.fmi3GetDirectionalDerivative(fmu.component, a, len(a), b, len(b), vector(v, f64), len(v), jv, len(jv))
    fmu.fmi3GetAdjointDerivative(fmu.component, a, len(a), b, len(b), vector(w, f64), len(w), wj, len(wj))
    left, right = float(w @ np.array(jv)), float(v @ np.array(wj))
    assert left == pytest.approx(right, rel=1e-10)
    assert abs(left) > 1.0


def test_energy_is_kept_without_losses(four_link, fmus):
    """Friction, damping and controller off: the swinging arm keeps its energy over 10 s."""
    lossy = ("coulomb", "viscous", "d[1]", "d[2]", "d[3]")
    off = {n: 0.0 for n in four_link.parameters if n.endswith(lossy)}
    off |= {f"joint{k}.{gain}": 0.0 for k in range(1, 5) for gain in ("Kp", "Kd", "Ki")}
    time = np.arange(2501) * 0.004
    pose = np.tile([0.3, np.pi - 0.1, 0.1, 0.2], (len(time), 1))  # hanging
    speeds = tuple(n.replace(".e", ".de", 1) for n in four_link.coordinates)
    push = np.zeros_like(pose)
    push[1:50] = [20.0, 30.0, 10.0, 5.0]
    with LoadedFmu(fmus[2]) as fmu:
        log = fmu.simulate(Experiment(time, pose, push), off, outputs=speeds)
    energy = total_energy(four_link, log, speeds)
    assert np.abs(log["joint1.e"]).max() > 1.0
    assert np.ptp(energy) / np.abs(energy).max() < 1e-6


def total_energy(robot, log, speeds):
    """Kinetic, elastic and potential energy minus the work of the torques, by Pinocchio."""
    pinocchio_model = pytest.importorskip("pinocchio_model", reason="Pinocchio is not installed")
    oracle = pinocchio_model.PinocchioRobot(robot)
    q, v = log[list(robot.coordinates)].to_numpy(), log[list(speeds)].to_numpy()
    armature = np.r_[[robot.parameters[f"joint{k}.J_m"] for k in range(1, 5)], np.zeros(12)]
    stiffness = np.array([robot.parameters[n.replace("eps", "k")] for n in robot.coordinates[4:]])
    kinetic = [0.5 * b @ (oracle.mass_matrix(a) + np.diag(armature)) @ b for a, b in zip(q, v, strict=True)]
    elastic = 0.5 * (q[:, 4:] ** 2 @ stiffness)
    potential = [oracle.potential_energy(a) for a in q]
    tau = log[[f"joint{k}.tau" for k in range(1, 5)]].to_numpy()
    work = np.concatenate([[0.0], np.cumsum((tau[:-1] * np.diff(q[:, :4], axis=0)).sum(axis=1))])
    return np.array(kinetic) + elastic + np.array(potential) - work


def test_names_units_and_order(four_link):
    eq = equations(four_link)
    listed = variables(eq)
    assert len({v.name for v in listed}) == len(listed)
    assert all(v.description for v in listed)
    assert [v.name for v in listed if v.derivative_of] == [f"der({n})" for n in states(eq)]
    assert base_units("N.m/(rad.s)") == {"kg": 1, "m": 2, "s": -3, "rad": -1}
    names = [v.name for v in listed]
    for array in arrays(eq.joints):
        at = names.index(array.first)
        assert len({v.unit for v in listed[at : at + array.size]}) == 1
