"""A servo whose torque constant and delay are guesses: found in the logs before all is judged by them."""

import numpy as np
import pandas as pd
import pytest
from servo_pendulum import guessed, stepped

import pyident as pi


def _logs(load: float = 0.0, spring: float = 0.0, off: tuple[int, ...] = ()) -> list[pd.DataFrame]:
    """Four of 8 s at 100 Hz, by Euler's method; off: instants [ms] from which the first have no drive."""
    logs, time = [], 1e-3 * np.arange(8000)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        waves = [(rng.uniform(0.3, 0.8), rng.uniform(0.5, 5), rng.uniform(0, 6)) for _ in range(4)]
        reference = sum((a * np.sin(w * time + p) for a, w, p in waves), 0 * time) * np.minimum(time, 1)
        last = off[seed] if seed < len(off) else len(time)
        e, on = stepped(reference, load, spring, switched_off=last), (1000 * time < last - 0.5).astype(float)
        columns = {"time": time, "joint1.r": reference, "joint1.e": e, "joint1.on": on}
        logs.append(pd.DataFrame(columns)[::10])
    return [log.reset_index(drop=True) for log in logs]


@pytest.mark.parametrize("held", [False, True])
def test_guesses_are_no_reason_for_an_alarm(held):
    """held: the commands stay from sample to sample, as of a computer that sends one when it logs one."""
    logs = _logs()
    for log in logs if held else ():
        log["joint1.e"] = stepped(np.repeat(log["joint1.r"].to_numpy(), 10))[::10]
    found = pi.diagnose(guessed(), logs)
    assert found.verdict == "nothing_detectable"
    assert any("found in these logs first" in note for note in found.notes)


@pytest.mark.parametrize(
    ("hidden", "effect"), [({"load": 0.3}, "load_dependent_friction"), ({"spring": 0.25}, "joint_spring")]
)
def test_an_effect_that_bends_the_delay_is_named(hidden, effect):
    found = pi.diagnose(guessed(), _logs(**hidden)).diagnosis
    assert effect in [named.effect for named in found.findings[0].tie]
    assert not {"torque_delay", "servo_delay"} & {n.effect for f in found.findings for n in f.tie}


def test_a_servo_that_goes_off_is_judged_beside_the_others():
    """In the middle of two logs: the arm drops, and its torque jumps between two samples."""
    assert pi.diagnose(guessed(), _logs(off=(4000, 5500))).verdict == "nothing_detectable"
