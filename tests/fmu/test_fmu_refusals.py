"""What an FMU must not take: it refuses with a sentence and keeps its value."""

from ctypes import byref, c_char, c_size_t, c_ubyte, c_void_p
from dataclasses import replace

import numpy as np
import pytest
from fmpy import read_model_description
from fmu_listening import OPENED

import pyident as pi
from flexfmu.build import BuildError
from flexfmu.inertia import require_inertia
from flexfmu.names import fmi_name
from flexmodels.mechanics.plant import equations


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


@pytest.fixture
def opened(fmus, fmi):
    return OPENED[fmi](fmus[fmi], [])


both = pytest.mark.parametrize("fmi", [2, 3])


@both
def test_a_minimum_that_is_declared_may_be_set(opened, fmus, fmi):
    """FMI 2.0.4, 2.2.7: the minimum is among the values."""
    variables = read_model_description(str(fmus[fmi])).modelVariables
    minima = {v.name: float(v.min) for v in variables if v.min is not None}
    assert {"joint1.k[1]", "joint1.J_m", "joint1.coulomb"} <= set(minima)
    for name, minimum in minima.items():
        opened.write(opened.vr[name], minimum)


@both
@pytest.mark.parametrize(
    ("time", "step", "words"),
    [
        (0.0, -0.01, "cannot be taken"),
        (0.0, np.inf, "cannot be taken"),
        (0.0, np.nan, "cannot be taken"),
        (0.0, 1e300, "cannot be taken"),
        (0.5, 0.01, "stands at 0 s"),
        (np.nan, 0.01, "stands at 0 s"),
        (-np.inf, 0.01, "stands at 0 s"),
    ],
)
def test_steps_that_cannot_be_taken(opened, time, step, words):
    opened.start()
    before = opened.read(opened.vr["joint1.e"])
    with pytest.raises(Exception, match="status"):
        opened.step(time, step)
    assert words in opened.said[-1]
    assert opened.read(opened.vr["joint1.e"]) == before
    opened.step(0.0, 0.0)  # no time is a step that may be taken
    opened.step(0.0, 0.01)


@both
def test_inertia_that_no_body_has_is_refused_at_the_start(opened):
    for name in ("link4.J[xx]", "link4.J[yy]", "link4.J[zz]"):
        opened.write(opened.vr[fmi_name(name)], -50.0)
    with pytest.raises(Exception, match="status"):
        opened.start()
    assert "mass matrix is not positive definite" in opened.said[-1]


@both
def test_inertia_that_no_body_has_is_refused_on_the_way(opened):
    opened.start()
    opened.step(0.0, 0.01)
    for name in ("link4.J[xx]", "link4.J[yy]", "link4.J[zz]"):
        opened.write(opened.vr[fmi_name(name)], -50.0)
    with pytest.raises(Exception, match="status"):
        opened.step(0.01, 0.01)
    assert "not positive definite at 0.01 s" in opened.said[-1]


@both
def test_products_of_inertia_that_no_body_has_are_refused(opened):
    opened.write(opened.vr[fmi_name("link4.J[xy]")], 50.0)
    with pytest.raises(Exception, match="status"):
        opened.start()
    assert "mass matrix is not positive definite" in opened.said[-1]


BYTE = {"fmi2": c_char, "fmi3": c_ubyte}


def saved(opened):
    state = c_void_p()
    name = "GetFMUstate" if opened.prefix == "fmi2" else "GetFMUState"
    getattr(opened.fmu, opened.prefix + name)(opened.fmu.component, byref(state))
    return state


def spelled(opened, name):
    if opened.prefix == "fmi3":
        return name
    return name.replace("State", "state").replace("Deserialize", "DeSerialize")


def serialised(opened, state):
    size = c_size_t()
    of = opened.fmu
    getattr(of, opened.prefix + spelled(opened, "SerializedFMUStateSize"))(of.component, state, byref(size))
    raw = (BYTE[opened.prefix] * size.value)()
    getattr(of, opened.prefix + spelled(opened, "SerializeFMUState"))(of.component, state, raw, size)
    return bytes(raw)


@both
def test_states_of_others_and_freed_ones_are_refused(opened, fmus, fmi):
    opened.start()
    other = OPENED[fmi](fmus[fmi], [])
    other.start()
    theirs, own = saved(other), saved(opened)
    kept = c_void_p(own.value)
    free = getattr(opened.fmu, opened.prefix + spelled(opened, "FreeFMUState"))
    free(opened.fmu.component, byref(own))
    assert not own.value
    restore = spelled(opened, "SetFMUState")
    for state in (theirs, kept, c_void_p(), c_void_p(8)):
        assert "not a state that this instance saved" in opened.call(restore, state)
    opened.step(0.0, 0.01)


@both
def test_bytes_that_are_no_state_are_refused(opened):
    opened.start()
    raw = serialised(opened, saved(opened))
    flipped = bytearray(raw)
    flipped[len(raw) // 2] ^= 1
    for content in (bytes(len(raw)), bytes(flipped), raw[:-1], raw + b"0", b""):
        said = opened.call(
            spelled(opened, "DeserializeFMUState"),
            (BYTE[opened.prefix] * max(1, len(content))).from_buffer_copy(content or b"0"),
            len(content),
            byref(c_void_p()),
        )
        assert "not a whole state" in said
    opened.step(0.0, 0.01)


MISSING: dict[int, list[tuple]] = {
    2: [
        ("GetReal", None, 1, None),
        ("SetReal", None, 1, None),
        ("GetFMUstate", None),
        ("FreeFMUstate", None),
    ],
    3: [
        ("GetFloat64", None, 1, None, 1),
        ("SetFloat64", None, 1, None, 1),
        ("GetFMUState", None),
        ("FreeFMUState", None),
        ("GetNumberOfContinuousStates", None),
    ],
}


@both
def test_missing_pointers_are_named(opened, fmi):
    for name, *arguments in MISSING[fmi]:
        said = opened.call(name, *arguments)
        assert said.startswith("A pointer is missing in the call of ")
        assert said.endswith(f"fmi{fmi}{name}.")


def test_a_robot_without_inertia_is_not_written(tmp_path):
    """The shipped description of TX40 has none about its last axis; with one it is complete."""
    path = tmp_path / "plant.fmu"
    with pytest.raises(BuildError, match=r"at joint6 has .* give joint6\.J_m .*--set joint6\.J_m=VALUE"):
        pi.export_fmu("tx40", path, part="plant")
    assert not path.exists()
    tx40 = equations(pi.load_robot("tx40"))
    require_inertia(replace(tx40, parameters=tx40.parameters | {"joint6.J_m": 1e-3}))
