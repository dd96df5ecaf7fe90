"""The FMU as a citizen: its contents, both standards, both kinds, states, the recorded run."""

import io
import zipfile

import matplotlib.image
import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
from fmu_by_hand import Opened

from flexfmu.files.units import base_units
from flexfmu.simulate import LoadedFmu
from flexfmu.variable import arrays
from flexfmu.variables import states, variables
from flexmodels.experiment import identification
from flexmodels.mechanics.plant import equations

TIP = ["tip.x", "tip.y", "tip.z"]


@pytest.fixture(scope="module")
def plan(four_link):
    return identification(four_link, duration=0.5)


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
            relative_tolerance=float(option["RelTol"]) * 1e-2 if interface == "ModelExchange" else None,  # pyright: ignore[reportArgumentType]
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
