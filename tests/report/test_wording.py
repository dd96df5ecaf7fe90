"""Numbers as an engineer writes them."""

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyident.report.wording import measured, number, percent, unit


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1235.4, "1\u202f235"), (0.012345, "0.0123"), (-2.5, "−2.50"), (3.2e9, "3.20 × 10⁹"),
     (-4.56e-7, "−4.56 × 10⁻⁷"), (inf, "∞")],
)  # fmt: skip
def test_numbers(value, text):
    assert number(value) == text


@given(st.floats(1e-12, 1e12), st.integers(1, 6))
def test_a_number_keeps_its_digits(value, digits):
    text = number(value, digits).replace("\u202f", "").replace("−", "-")
    mantissa, _, power = text.partition(" × 10")
    exponent = int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 0)
    assert float(mantissa) * 10.0**exponent == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits))


def test_an_interval_is_of_95_percent():
    assert measured(10.123, 0.05) == "10.123"


def test_small_shares_are_said_to_be_small():
    assert percent(0.01) == "<\u00a00.1\u00a0%"
    assert percent(12.34) == "12.3\u00a0%"


def test_units():
    assert unit("N.m.s2/rad2") == "N m s²/rad²"
    assert unit("1") == ""
