"""Links that swing on their drives near the motion's frequencies: springs integrated beside Pinocchio."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from six_axis_logs import COULOMB, ROTOR, VISCOUS, arm
from studies.rigid_arm.arm import moved, recorded, torque_noise
from studies.rigid_arm.pinocchio_chain import chain, pinocchio

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log

PACE, STEP = 8.0, 0.0025  # of sines up to 2.9 Hz; s
COMPLIANCE = {1: 4.5e-4, 2: 5.5e-4, 3: 2e-3}  # rad/(N m): links swing at 4 to 5 Hz
DAMPING = 0.04


def never(_):
    raise AssertionError("without a known controller nothing is simulated")


def swinging(seed: int, compliance: dict[int, float]) -> Log:
    """Motors follow a plan; what links carry is what their springs do, by classical Runge-Kutta."""
    rng = np.random.default_rng(seed)
    plan = moved(arm(), rng, 20.0, PACE)
    course = make_interp_spline(plan.time, plan.q, k=5)
    motor = [course, course.derivative(), course.derivative(2)]
    pin, model = pinocchio(), chain(arm())
    data, free = model.createData(), [k - 1 for k in compliance]
    K = np.array([1 / c for c in compliance.values()])
    first = pin.crba(model, data, plan.q[0])[free, free]
    D = 2 * DAMPING * np.sqrt(K * first)

    def rate(t, x):
        q, v, a = (own(t) for own in motor)
        wound, winding = q[free] - x[0], v[free] - x[1]
        q[free], v[free], a[free] = x[0], x[1], 0.0
        asked = pin.rnea(model, data, q, v, a)
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        faster = np.linalg.solve(M[np.ix_(free, free)], K * wound + D * winding - asked[free])
        a[free] = faster
        return np.array([x[1], faster]), pin.rnea(model, data, q, v, a)

    every = round((plan.time[1] - plan.time[0]) / STEP)
    x, load = np.array([plan.q[0][free], plan.v[0][free]]), []
    x[0] -= plan.load[0][free] / K
    for i in range(every * (len(plan.time) - 1) + 1):
        t = i * STEP
        k1, torque = rate(t, x)
        if i % every == 0:
            load.append(torque)
        k2 = rate(t + STEP / 2, x + STEP / 2 * k1)[0]
        k3 = rate(t + STEP / 2, x + STEP / 2 * k2)[0]
        k4 = rate(t + STEP, x + STEP * k3)[0]
        x = x + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    motion = replace(plan, load=np.array(load))
    tau = motion.load + ROTOR * motion.a + COULOMB * np.sign(motion.v) + VISCOUS * motion.v
    return recorded(motion, tau, torque_noise(tau), rng, f"log {seed}")


@pytest.mark.slow
@pytest.mark.parametrize("joints", [(2,), (1, 2), (1, 2, 3)])
def test_drives_are_named_with_their_springs(joints):
    compliance = {k: COMPLIANCE[k] for k in joints}
    logs = [swinging(seed, compliance) for seed in range(3)]
    found = concluded(searched(arm(), logs[:2], never), never, logs[2:])
    named = {int(f.tie[0].joint[-1]): f.tie[0] for f in found.findings}
    assert {n.effect for n in named.values()} == {"drive_compliance"}
    assert set(named) == set(joints)
    assert named[2].values["correction"] == pytest.approx(
        compliance[2], rel=0.2
    )  # joint 1 splits its inertia
    assert all(min(f.share_percent, f.heldout_gain_percent or 0.0) > 90 for f in found.findings)
