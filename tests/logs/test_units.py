"""Units against the constants of SciPy, and a mapping that goes there and back."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import constants

from pyident.logs.foreign import import_log
from pyident.logs.formats.delimited import read_delimited
from pyident.logs.log import LogError
from pyident.logs.mapping import Mapping, Source
from pyident.logs.units import FACTORS, factor, known_unit

# Unit -> value in SI, from SciPy's CODATA tables or by definition of its prefix.
KNOWN = {
    "deg": constants.degree,
    "mrad": constants.milli,
    "rev": constants.pi * 2,
    "deg/s": constants.degree,
    "rpm": 2 * constants.pi / constants.minute,
    "rev/s": constants.pi * 2,
    "in": constants.inch,
    "cm": constants.centi,
    "mm": constants.milli,
    "um": constants.micro,
    "mm/s": constants.milli,
    "ms": constants.milli,
    "us": constants.micro,
    "ns": constants.nano,
    "mN.m": constants.milli,
    "mNm": constants.milli,
    "kN.m": constants.kilo,
    "kNm": constants.kilo,
    "kN": constants.kilo,
    "N.cm": constants.centi,
    "Ncm": constants.centi,
    "N.mm": constants.milli,
    "Nmm": constants.milli,
    "kgf.m": constants.kilogram_force,
    "kgf.cm": constants.kilogram_force * constants.centi,
    "lbf.ft": constants.pound_force * constants.foot,
    "lbf.in": constants.pound_force * constants.inch,
    "mA": constants.milli,
    "mV": constants.milli,
    "%": constants.centi,
    "‰": constants.milli,
}
SI = ("s", "rad", "m", "rad/s", "m/s", "N.m", "Nm", "N", "A", "V", "1")


def test_every_unit_is_one_of_ours_and_right():
    assert set(FACTORS) == {*KNOWN, *SI}
    for unit, value in KNOWN.items():
        assert factor(unit, "unit") == pytest.approx(value, rel=1e-12), unit
    assert all(factor(unit, "unit") == 1.0 for unit in SI)


def test_an_unknown_unit_names_its_place():
    with pytest.raises(LogError, match=r"signals\.q\.unit = 'degrees' is not a known unit"):
        factor("degrees", "signals.q.unit")


@pytest.mark.parametrize(
    ("unit", "ours"),
    [
        ("grd", "deg"),
        ("Grad", "deg"),
        ("GRD", "deg"),
        ("[grd]", "deg"),
        ("grd/s", "deg/s"),
        ("Grad/s", "deg/s"),
    ],
)
def test_degrees_are_known_as_german_controllers_write_them(unit, ours):
    assert known_unit(unit) == ours


@pytest.mark.parametrize("own", [True, False], ids=["as in the file", "without units"])
def test_units_in_the_names_are_read_and_a_mapping_may_repeat_them(own, tmp_path):
    (tmp_path / "a.csv").write_text(
        "t[ms];A1_ist[grd];A1_strom [A]\n" + "".join(f"{4 * i};{90 + i};{i / 2}\n" for i in range(9))
    )
    recording = read_delimited(tmp_path / "a.csv")
    assert list(recording.columns) == ["t", "A1_ist", "A1_strom"]
    assert recording.units == {"t": "ms", "A1_ist": "grd", "A1_strom": "A"}
    names = ("t[ms]", "A1_ist[grd]", "A1_strom [A]") if own else ("t", "A1_ist", "A1_strom")
    mapping = Mapping(
        {
            "time": Source(names[0], 1e-3),
            "joint1.e": Source(names[1], factor("deg", "")),
            "joint1.tau": Source(names[2]),
        }
    )
    frame = import_log([tmp_path / "a.csv"], mapping).frame
    assert frame["joint1.e"].to_numpy() == pytest.approx(np.deg2rad(90.0 + np.arange(9)))
    assert frame["joint1.tau"].to_numpy() == pytest.approx(np.arange(9) / 2)
    with pytest.raises(LogError, match=r"there is no column A2_ist\[V\]"):
        import_log([tmp_path / "a.csv"], Mapping(mapping.signals | {"joint1.e": Source("A2_ist[V]")}))


@settings(max_examples=25, deadline=None)
@given(
    unit=st.sampled_from(sorted(FACTORS)),
    sign=st.sampled_from([-1.0, 1.0]),
    gain=st.floats(0.01, 100.0),
    offset=st.floats(-100.0, 100.0),
    seed=st.integers(0, 1000),
)
def test_what_was_written_in_a_unit_is_read_in_si(tmp_path_factory, unit, sign, gain, offset, seed):
    """A signal in SI, written as theirs, comes back through the mapping."""
    file = tmp_path_factory.mktemp("units") / "theirs.csv"
    signal = np.random.default_rng(seed).standard_normal(40)
    scale = sign * gain * factor(unit, "unit")
    theirs = (signal - offset * factor(unit, "unit")) / scale
    pd.DataFrame({"t": 0.01 * np.arange(40), "x": theirs}).to_csv(file, index=False)
    mapping = Mapping({"time": Source("t"), "joint1.e": Source("x", scale, offset * factor(unit, "unit"))})
    assert import_log([file], mapping).frame["joint1.e"].to_numpy() == pytest.approx(signal, abs=1e-9)
