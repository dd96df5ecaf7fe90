"""A law that is added to a rigid robot in an unknown loop whose encoders are noisy."""

from dataclasses import replace

import numpy as np
import pytest
from six_axis_logs import arm, made, three_laws

from pyident.extension.add_effect import add_effect
from pyident.simulation.fmu_runs import FmuRuns

ENCODER = 1e-4  # rad: differenced twice at 100 Hz 2.4 rad/s2


def noisy(seed):
    log, rng = made(arm(), seed, three_laws, 20.0, 3.0), np.random.default_rng(seed)
    moved = {
        f"joint{k}.e": log.frame[f"joint{k}.e"] + ENCODER * rng.normal(size=len(log)) for k in range(1, 7)
    }
    return replace(log, frame=log.frame.assign(**moved))


@pytest.mark.slow
def test_its_errors_are_those_of_the_torque_and_not_of_noise_that_was_differenced():
    logs = [noisy(seed) for seed in range(3)]
    done = add_effect(arm(), 2, "load_dependent_friction", logs[:2], logs[2:], FmuRuns, lambda _: None)
    assert done.accepted, done.reason
    (before,), (after,) = done.before, done.after
    first, then = before.equations["joint2.e"], after.equations["joint2.e"]
    torque = np.std(logs[2].signals(["joint2.tau"]))
    assert first.rmse < 0.2 * torque
    assert then.rmse < 0.5 * first.rmse
    assert then.floor < 0.05 * torque
    values = done.robot.parameters
    assert values["joint2.load_dependent_friction.coefficient"] == pytest.approx(0.12, rel=0.15)
