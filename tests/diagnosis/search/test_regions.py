"""A law is judged in the bands where it acts, and beside a ripple as if it were alone."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import analytic_log, free_joint

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.result import Diagnosis
from pyident.diagnosis.search.gate import region_of, share_in
from pyident.diagnosis.search.remainder import may_be_remainder
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import runs_here

SIGMA = 0.02  # N m of white noise


def log_of(torque, seed: int) -> Log:
    """With a further torque f(q, v, t) [N m]."""
    log = analytic_log(seconds=18.0 + seed, torque_noise=SIGMA, seed=seed)
    q, tau, t = (log.frame[name].to_numpy() for name in ("joint1.e", "joint1.tau", "time"))
    v = np.gradient(q, t)
    return replace(log, frame=log.frame.assign(**{"joint1.tau": tau + torque(q, v, t)}))


def search_of(torque) -> Search:
    return searched(free_joint(), [log_of(torque, 0), log_of(torque, 1)], runs_here).resting_on(())


def diagnosed(torque) -> Diagnosis:
    logs = [log_of(torque, seed) for seed in range(3)]
    return concluded(searched(free_joint(), logs[:2], runs_here), runs_here, logs[2:])


def names(found: Diagnosis) -> set[str]:
    return {f.tie[0].effect for f in found.findings}


def grease(q, v, t):
    return 0.1 * np.abs(v) * v


def hose(q, v, t):
    return 0.5 * q


def test_what_is_taken_of_low_bands_is_not_counted_over_the_high_ones():
    """A wave between 5 and 35 Hz has as much energy as a spring below 1 Hz."""
    search = search_of(lambda *x: hose(*x) + resonant(*x))
    spring = search.best("joint_spring", 1)
    assert spring is not None
    low, everywhere = Region((0,), (0, 1)), Region((0,))
    assert share_in(search, [spring.candidate], everywhere) < 0.8
    assert share_in(search, [spring.candidate], low) > 0.95
    assert search.remaining_in(low) < search.remaining_in(everywhere) == search.remaining_on([0])


def test_a_law_acts_on_its_own_row():
    search = search_of(hose)
    spring = search.best("joint_spring", 1)
    assert spring is not None
    assert region_of(search, spring.candidate).rows == (0,)


def test_a_region_meets_another_in_a_row_and_a_band():
    low, high = Region((0, 1), (0, 1)), Region((1,), (1, 2))
    assert low.meets(high)
    assert not low.meets(Region((2,), (1,)))
    assert not low.meets(Region((1,), (2, 3)))


def test_a_slow_law_is_no_remainder_of_a_ripple_and_a_ripple_none_of_it():
    search = search_of(lambda q, v, t: grease(q, v, t) + 0.4 * np.sin(40 * q))
    ripple, law = search.best("torque_ripple", 1), search.best("nonlinear_viscous", 1)
    assert ripple is not None
    assert law is not None
    for first, second in ((ripple, law), (law, ripple)):
        view = search.resting_on([first.candidate])
        step = search.led_by(first, [first])
        assert not may_be_remainder(view, second.candidate, step, region_of(view, second.candidate))


def test_what_one_friction_leaves_may_be_another():
    search = search_of(grease)
    law, other = search.best("nonlinear_viscous", 1), search.best("stribeck", 1)
    assert law is not None
    assert other is not None
    view, step = search.resting_on([law.candidate]), search.led_by(law, [law])
    assert may_be_remainder(view, other.candidate, step, region_of(view, other.candidate))


def resonant(q, v, t):
    """A ripple of 40 per turn that an oscillator of 9 Hz answers."""
    speed = 40 * v / (2 * np.pi * 9.0)
    return 0.2 * np.real(np.exp(40j * q) / (1 - speed**2 + 0.3j * speed))


def test_a_ripple_that_shakes_the_arm_has_its_order_and_a_size_at_every_speed():
    found = diagnosed(lambda *x: resonant(*x) + grease(*x))
    assert names(found) == {"torque_ripple", "nonlinear_viscous"}
    (ripple,) = [f.tie[0] for f in found.findings if f.tie[0].effect == "torque_ripple"]
    assert ripple.values["order"] == pytest.approx(40, abs=0.3)
    assert set(ripple.values) == {"cosine", "sine", "order"}
    (note,) = [n for n in found.notes if "its size and phase are those of the speed" in n]
    assert "or a loop answers: from 0." in note


def test_one_size_at_all_speeds_is_enough_for_a_plain_ripple():
    found = diagnosed(lambda q, v, t: 0.3 * np.sin(40 * q + 0.3))
    assert names(found) == {"torque_ripple"}
    assert not any("those of the speed" in n for n in found.notes)


def test_candidates_fitted_together_have_the_coefficients_of_one_least_squares():
    search = search_of(lambda q, v, t: grease(q, v, t) + 0.4 * np.sin(40 * q))
    ripple = search.best("torque_ripple", 1)
    assert ripple is not None
    listed = [ripple.candidate, Candidate("nonlinear_viscous", 1, (("power", 2.0),))]
    p, x = search.fitted(listed)
    logs = search.examination.logs
    X = [search.columns(c) for c in listed]
    A = np.vstack([np.hstack([e.A[0], *(own[i][0] for own in X)]) for i, e in enumerate(logs)])
    y = np.concatenate([e.y[0] for e in logs])
    scale = np.linalg.norm(A, axis=0)
    scale[scale == 0] = 1.0
    whole = np.linalg.lstsq(A / scale, y, rcond=None)[0] / scale
    np.testing.assert_allclose(x, whole[-len(x) :], rtol=1e-4, atol=1e-6 * np.abs(x).max())
    np.testing.assert_allclose(
        A[:, : len(p)] @ p, A[:, : len(p)] @ whole[: len(p)], atol=1e-3 * np.abs(y).max()
    )
