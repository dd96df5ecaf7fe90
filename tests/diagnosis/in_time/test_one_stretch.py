"""A push in one of three logs, and noise, ripples and drifts that are everywhere."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pyident.diagnosis.unexplained.in_time import course, one_stretch
from pyident.regression.spectrum import Band
from pyident.rules.rules import RULES

BAND = Band(length=2000, bins=400, period=0.01)
SAMPLES = 1990
TIME = 0.01 * np.arange(SAMPLES)


def found(extra, at: int = 1):
    """Of three logs of unit noise; extra (N,) in one of them."""
    rng = np.random.default_rng(0)
    made = [rng.standard_normal(SAMPLES) for _ in range(3)]
    made[at] += extra
    logs = [SimpleNamespace(band=BAND, part=SimpleNamespace(target=np.zeros((SAMPLES, 1)))) for _ in made]
    residual = [BAND.transform(x) for x in made]
    floor = 3.0 * 2 * BAND.bins
    return one_stretch(cast(Any, logs), residual, floor, RULES.unexplained)


def test_a_course_comes_back():
    smooth = np.sin(2 * np.pi * 1.5 * TIME) * np.exp(-((TIME - 8) ** 2))
    assert course(BAND, BAND.transform(smooth), SAMPLES) == pytest.approx(smooth, abs=1e-6)


def test_a_push_is_found_where_it_was():
    push = 12 * np.sin(np.pi * np.clip(TIME - 7, 0, 1))
    stretch = found(push)
    assert stretch is not None
    assert stretch.log == 1
    assert stretch.start + 0.1 >= 7.0
    assert stretch.end - 0.1 <= 8.0
    assert stretch.share > 0.6


@pytest.mark.parametrize(
    "extra", [0 * TIME, 2 * np.sin(9 * TIME), 0.3 * (TIME - 10)], ids=["none", "ripple", "drift"]
)
def test_what_is_everywhere_is_no_event(extra):
    assert found(extra) is None
