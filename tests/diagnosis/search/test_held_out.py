"""What exceeds the floor, band by band; and whether a share on logs that were not fitted may be believed."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.base.residual_over_floor import Examination
from pyident.diagnosis.search.held_out import HeldOut, Unseen
from pyident.rules.rules import RULES

SEARCH = RULES.search


def examination(replicas: list[list[float]], count: list[float]) -> Examination:
    """Of one equation: mean square that each replica leaves in every band, and the bands' equations."""
    found = SimpleNamespace(replica_energy=np.array(replicas)[:, None, :], count=np.array(count))
    return cast(Any, found)


def test_a_floor_too_high_in_one_band_hides_nothing_in_another():
    """Twice four of a low band at 3² each, where replicas leave 1; four of a high one at 0, where 9."""
    residual = np.array([[3.0] * 4 + [0.0] * 4])
    bands = np.repeat(np.eye(2), 4, axis=0)
    ex = examination([[0.5, 8.0], [1.5, 10.0]], [4.0, 4.0])
    beyond, floor = Examination.excess(ex, [residual, residual], [bands, bands], [0])
    assert beyond == pytest.approx(2 * 4 * (9 - 1))
    assert floor == pytest.approx(2 * 4 * (1 + 9))


def test_what_lies_in_bands_that_no_fitted_log_has_does_not_count():
    residual = np.array([[2.0] * 4 + [5.0] * 4])
    bands = np.repeat(np.eye(2), 4, axis=0)
    ex = examination([[1.0, 0.0]], [4.0, 0.0])
    assert Examination.excess(ex, [residual], [bands], [0]) == pytest.approx((4 * (4 - 1), 4 * 1))


@pytest.mark.parametrize(
    ("unseen", "fitted", "holds"),
    [
        (Unseen(0.80, 0.10, 5.0, 1.0), 0.90, True),
        (Unseen(0.40, 0.10, 5.0, 1.0), 0.90, False),  # less than half of what was fitted
        (Unseen(0.60, 0.70, 5.0, 1.0), 0.90, False),  # as much by chance
        (Unseen(0.40, 0.07, 0.1, 0.9), 0.42, True),  # hardly anything to explain, but what it says is there
        (Unseen(0.08, 0.07, 0.1, 0.9), 0.42, False),  # by chance, perhaps
        (Unseen(0.40, 0.07, 0.1, 0.3), 0.42, False),  # most of it is not
        (Unseen(-0.01, 0.07, 0.1, -0.5), 0.42, False),
    ],
)
def test_a_share_on_unseen_logs_must_stand_beside_the_fitted_one(unseen, fitted, holds):
    assert HeldOut(()).holds(unseen, fitted, SEARCH) == holds


@pytest.mark.parametrize(("kept", "deviations"), [(1.0, 8.0), (0.5, 12.0), (-0.5, 0.0)])
def test_what_held_out_logs_alone_say_of_a_size(kept, deviations):
    """The fall is Σ 2rs - s², and rs has half its deviation: 0.4 and 0.1 of the excess."""
    assert Unseen(0.4, 0.1, 0.1, kept).deviations == pytest.approx(deviations)


def test_what_fitted_logs_leave_open_of_the_parameters_counts():
    """Against the scatter of Σ s A p over fits to noise, which is all that there is to fit."""
    rng = np.random.default_rng(0)
    A, elsewhere = rng.standard_normal((2, 60, 3)), rng.standard_normal((2, 40, 3))
    taken = rng.standard_normal((1, 40))
    held = HeldOut((cast(Any, SimpleNamespace(A=elsewhere)),))
    said, found = [], []
    for _ in range(400):
        fitted = cast(Any, SimpleNamespace(A=A, y=rng.standard_normal((2, 60))))
        base = solve_base([fitted])
        said.append(held._of_parameters(base, [taken], [np.ix_([1], range(40))]))
        found.append(float((taken * (elsewhere[[1]] @ base.p)).sum()))
    assert np.mean(said) == pytest.approx(np.var(found), rel=0.2)
