"""A gear's ripple of ninety times a turn, far beyond any grid of orders: asked for by name, it is found."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import analytic_log, free_joint

from pyident.diagnosis.base.setting import set_up
from pyident.extension.ask import ask
from pyident.simulation.fmu_runs import runs_here

ORDER, COSINE, SINE = 91.3, 0.3, -0.2


def _log(seed):
    log = analytic_log(seconds=16.0, angle_noise=1e-7, torque_noise=0.05, seed=seed)
    angle = log.frame["joint1.e"]
    ripple = COSINE * np.cos(ORDER * angle) + SINE * np.sin(ORDER * angle)
    return replace(log, frame=log.frame.assign(**{"joint1.tau": log.frame["joint1.tau"] + ripple}))


def test_the_order_that_stands_out_is_tried():
    setting = set_up(free_joint(), [_log(1)])
    asked = ask(setting, 1, "torque_ripple", [_log(2)], runs_here, lambda _: None)
    assert dict(asked.candidate.values)["order"] == pytest.approx(ORDER, rel=1e-3)
    assert asked.found.gain.coefficients == pytest.approx([COSINE, SINE], abs=0.04)
    assert not asked.admission.reason
