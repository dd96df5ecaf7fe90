"""A controller that answers coarse encoders, and a drive that delivers late: where their torques lie."""

import numpy as np
import pandas as pd
from analytic_joint import analytic_log, free_joint
from scipy.signal import lfilter

from pyident.diagnosis.search.gate import beyond_motion
from pyident.diagnosis.searched import searched
from pyident.logs.log import Log
from pyident.simulation.fmu_runs import runs_here

J, VISCOUS, COULOMB, COUNT = 0.3, 0.7, 0.9, 2 * np.pi / 65536  # kg m2, N m s, N m, rad
PERIOD, ROWS, OWN = 1e-3, 8, 2 * np.pi * 6  # s of the loop, of these one logged, rad/s of the loop


def answering(seed: int) -> Log:
    """16 s of a loop that knows the angle by its counts, and the speed by these."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, 16, PERIOD)
    rates = 2 * np.pi * rng.uniform(0.1, 1.5, 5)
    reference = 0.25 * np.sin(np.outer(time, rates) + rng.uniform(0, 6, 5)).sum(axis=1)
    e, de, last, speed, rows = reference[0], 0.0, reference[0], 0.0, []
    for r in reference:
        read = COUNT * np.round(e / COUNT)
        speed, last = 0.6 * speed + 0.4 * (read - last) / PERIOD, read
        tau = J * (OWN**2 * (r - read) - 1.4 * OWN * speed)
        rows.append((read, tau))
        de += (tau - VISCOUS * de - COULOMB * np.tanh(1e3 * de)) / J * PERIOD
        e += de * PERIOD
    e, tau = np.transpose(rows[::ROWS])
    tau = tau + 0.02 * rng.standard_normal(len(tau))
    frame = pd.DataFrame({"time": time[::ROWS], "joint1.e": e, "joint1.tau": tau})
    return Log(frame, f"log {seed}")


def late(seed: int) -> Log:
    """Of a drive whose torque comes 20 ms late."""
    log = analytic_log(seconds=16.0 + seed, torque_noise=0.02, seed=seed)
    share = 1 - np.exp(-log.period / 0.02)
    tau = lfilter([1.0, share - 1], [share], log.frame["joint1.tau"])  # commanded, of what it delivers
    return Log(log.frame.assign(**{"joint1.tau": tau}), "late")


def torque_delay_of(logs: list[Log]):
    search = searched(free_joint(), logs, runs_here)
    found = search.best("torque_delay", 1)
    assert found is not None
    return search, found.candidate


def test_a_controller_that_answers_counts_is_beyond_the_motion():
    search, delay = torque_delay_of([answering(0), answering(1)])
    assert beyond_motion(search, delay)


def test_a_late_torque_is_of_the_motion():
    search, delay = torque_delay_of([late(0), late(1)])
    assert not beyond_motion(search, delay)
