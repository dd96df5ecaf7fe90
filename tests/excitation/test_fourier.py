"""Any vector of numbers is a motion that rests at its ends and keeps position, speed and acceleration."""

import numpy as np
import pytest

from pyident.excitation.fourier import Family
from pyident.excitation.limits import Limits

LIMITS = Limits(
    lower=np.array([-1.0, -0.2]),
    upper=np.array([2.0, 0.4]),
    speed=np.array([1.5, 0.3]),
    acceleration=np.array([6.0, 2.0]),
    torque=np.array([np.inf, np.inf]),
    home=np.array([0.0, 0.1]),
)


@pytest.mark.parametrize("seed", range(5))
def test_every_member_keeps_its_limits_and_rests_at_its_ends(seed):
    family = Family(LIMITS, 8.0, harmonics=4)
    motion = family.reference(3 * np.random.default_rng(seed).standard_normal(family.size), 0.001)
    assert (motion.q >= LIMITS.lower - 1e-9).all()
    assert (motion.q <= LIMITS.upper + 1e-9).all()
    assert (np.abs(motion.dq) <= LIMITS.speed * 1.001).all()
    assert (np.abs(motion.ddq) <= LIMITS.acceleration * 1.005).all()
    assert motion.q[0] == pytest.approx(LIMITS.home)
    for ends in (motion.dq[[0, -1]], motion.ddq[[0, -1]]):
        assert np.abs(ends).max() < 1e-9


def test_its_derivatives_are_those_of_finite_differences():
    family = Family(LIMITS, 8.0, harmonics=4)
    motion = family.reference(np.random.default_rng(1).standard_normal(family.size), 0.0005)
    inner = slice(2, -2)
    speed = np.gradient(motion.q, motion.time, axis=0)
    assert speed[inner] == pytest.approx(motion.dq[inner], abs=1e-4)
    acceleration = np.gradient(motion.dq, motion.time, axis=0)
    assert acceleration[inner] == pytest.approx(motion.ddq[inner], abs=5e-2)


def test_the_way_from_home_shrinks_with_the_scale():
    family = Family(LIMITS, 8.0, harmonics=4)
    x = np.random.default_rng(2).standard_normal(family.size)
    whole, half = family.reference(x, 0.01), family.reference(x, 0.01, 0.5)
    assert half.q - LIMITS.home == pytest.approx((whole.q - LIMITS.home) / 2)
    assert half.ddq == pytest.approx(whole.ddq / 2)


@pytest.mark.parametrize("seed", range(3))
def test_in_a_short_time_slow_joints_stay_near_home(seed):
    """A way of 0.4 s has a peak acceleration of way / 0.4² times 10/√3: 0.166 m and 0.0554 m of way."""
    family = Family(LIMITS, 1.0, harmonics=4)
    way = np.array([6.0, 2.0]) * 0.4**2 * np.sqrt(3) / 10
    assert family.room == (pytest.approx(LIMITS.home - way), pytest.approx(LIMITS.home + way))
    motion = family.reference(3 * np.random.default_rng(seed).standard_normal(family.size), 0.001)
    assert (np.abs(motion.dq) <= LIMITS.speed * 1.001).all()
    assert (np.abs(motion.ddq) <= LIMITS.acceleration * 1.005).all()
