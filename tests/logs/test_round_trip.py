"""A log that is written is read as it was, in every format."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pyident.logs.log import Log, read_log, write_log

NAMES = ("joint1.e", "joint1.eps[1]", "joint1.eps[3]", "joint2.tau", "joint12.tau_ff", "tip.x")
NUMBERS = st.floats(-1e12, 1e12, allow_nan=False, width=64)


@st.composite
def _logs(draw):
    samples = draw(st.integers(2, 12))
    period = draw(st.sampled_from([1e-4, 1 / 250, 0.1, 1 / 3]))
    start = draw(st.sampled_from([0.0, -1.0, 4.0]))
    names = draw(st.lists(st.sampled_from(NAMES), min_size=1, unique=True))
    signals = {name: draw(arrays(float, samples, elements=NUMBERS)) for name in names}
    return Log(pd.DataFrame({"time": start + period * np.arange(samples)} | signals), "made")


@pytest.mark.parametrize("ending", ["csv", "parquet", "mat"])
@settings(max_examples=25, deadline=None)
@given(log=_logs())
def test_every_number_and_every_name(tmp_path_factory, ending, log):
    file = tmp_path_factory.mktemp("log") / f"log.{ending}"
    write_log(log, file)
    again = read_log(file)
    assert again.names == log.names
    np.testing.assert_array_equal(again.frame.to_numpy(), log.frame.to_numpy())
    assert again.period == log.period
