"""Several laws at one joint: a set is named where no law of it would be alone. Torques of a closed form."""

import numpy as np
import pandas as pd
import pytest
from analytic_joint import COULOMB, INERTIA, VISCOUS, free_joint

from pyident.diagnosis.base.residual_over_floor import Region
from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.search.gate import sets_for
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import runs_here

NOISE = 0.02  # N m


def log_of(seed: int, torque, viscous: float = VISCOUS) -> Log:
    """Four sines of a motion of its own, under the joint's usual torque and what `torque(q, v)` adds."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 20, 0.004)
    q, v, a = np.zeros((3, len(t)))
    for f in rng.uniform(0.1, 0.25) * np.array([1, 2.3, 4.1, 6.7]):
        w, phase, amplitude = 2 * np.pi * f, rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 0.6)
        q += amplitude * np.sin(w * t + phase)
        v += amplitude * w * np.cos(w * t + phase)
        a -= amplitude * w**2 * np.sin(w * t + phase)
    tau = INERTIA * a + viscous * v + COULOMB * np.sign(v) + torque(q, v)
    noise = NOISE * rng.standard_normal(len(t))
    return Log(pd.DataFrame({"time": t, "joint1.e": q, "joint1.tau": tau + noise}), f"motion {seed}")


def three(q, v):
    return (
        0.12 * np.sign(v) * np.cos(14 * q + 0.4)  # a wheel that is not round
        + 0.1 * np.maximum(v, 0)  # one direction is stiffer than the other
        + 0.1 * np.abs(v) * v  # grease
    )


def test_three_laws_at_one_joint_are_named_together():
    search = searched(free_joint(), [log_of(0, three)], runs_here)
    found = concluded(search, runs_here, [log_of(1, three)])
    ties = [{n.effect for n in f.tie} for f in found.findings]
    for effect in ("position_dependent_friction", "asymmetric_coulomb", "nonlinear_viscous"):
        assert any(effect in tie for tie in ties), found.sentence
    assert len(ties) == 3


def test_a_set_grows_by_what_takes_more_beside_the_others():
    search = searched(free_joint(), [log_of(0, three)], runs_here).resting_on(())
    held = held_out(search, [log_of(1, three)])
    step = search.step()
    sizes, left = [], []
    for steps, _ in sets_for(search, step, step.best, held):
        sizes.append(len(steps))
        left.append(search.with_further([s.best.candidate for s in steps]).base.energy)
    assert sizes == list(range(1, len(sizes) + 1))
    assert len(sizes) > 1
    assert np.all(np.diff(left) < 0)


def test_friction_that_has_warmed_up_does_not_hide_a_law_on_a_held_out_log():
    def grease(q, v):
        return 0.1 * np.abs(v) * v

    search = searched(free_joint(), [log_of(0, grease)], runs_here).resting_on(())
    law = search.best("nonlinear_viscous", 1)
    assert law is not None
    for viscous in (VISCOUS, 0.8 * VISCOUS):
        held = held_out(search, [log_of(1, grease, viscous)])
        unseen = held.share(search, [law.candidate], Region((0,)))
        assert unseen is not None
        assert unseen.share > 0.9
        assert unseen.kept > 0.9


def test_viscous_friction_that_grows_ever_slower_is_one_law_whatever_polynomial_it_is():
    """A power above one, a coefficient below zero: a power below one leaves what looks like Stribeck's."""

    def slower(q, v):
        return -0.1 * np.abs(v) * v

    logs = [log_of(seed, slower, 3 * VISCOUS) for seed in range(2)]
    found = concluded(searched(free_joint(), logs[:1], runs_here), runs_here, logs[1:])
    (law,) = [finding.tie[0] for finding in found.findings]
    assert law.effect == "nonlinear_viscous", found.sentence
    assert law.values["coefficient"] == pytest.approx(-0.1, rel=0.15)
    assert law.values["power"] == pytest.approx(2.0, abs=0.2)
    assert not [place for place in found.places if place.state == "unexplained"]
