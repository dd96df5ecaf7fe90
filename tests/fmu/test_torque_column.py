"""Which sample's torque a log holds, by the order in which an importer sets, reads and steps."""

import numpy as np
from fmpy import simulate_fmu

from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import identification


def test_fmpys_loop_records_the_torque_of_the_step_just_done(fmus, four_link):
    """docs/importers.md: its torque is late by one sample exactly, everything else is the same to the bit."""
    plan = identification(four_link, duration=0.4)
    names = [f"joint{k}.{s}" for s in ("r", "tau_ff") for k in range(1, 5)]
    table = np.zeros(len(plan.time), dtype=[(name, float) for name in ("time", *names)])
    table["time"] = plan.time
    for name, column in zip(names, np.hstack([plan.reference, plan.feedforward]).T, strict=True):
        table[name] = column
    torques, others = [f"joint{k}.tau" for k in range(1, 5)], ["joint2.e", "joint3.eps[2]", "tip.x"]
    late = simulate_fmu(
        str(fmus[2]),
        fmi_type="CoSimulation",
        stop_time=float(plan.time[-1]),
        output_interval=float(plan.time[1]),
        input=table,
        output=[*torques, *others],
    )
    with LoadedFmu(fmus[2]) as fmu:
        log = fmu.simulate(plan)
    assert np.abs(np.diff(log["joint2.tau"])).max() > 1.0
    for name in torques:
        assert (late[name][1:] == log[name].to_numpy()[:-1]).all()
    for name in others:
        assert (late[name] == log[name].to_numpy()).all()
