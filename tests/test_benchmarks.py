"""The peers of the benchmark simulate the same arm as our FMU; their speed is not a test."""

from pathlib import Path

import numpy as np
import pytest

from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import identification
from flexmodels.plant import equations

LOOSE = {f"joint{k}.coulomb": 0.0 for k in range(1, 5)}


@pytest.mark.parametrize("peer", ["mujoco", "pinocchio"])
def test_a_peer_moves_the_tip_as_our_fmu_does(four_link, four_link_fmu, peer, monkeypatch):
    pytest.importorskip(peer, reason=f"{peer} is not installed, so the benchmark leaves it out")
    monkeypatch.syspath_prepend(Path(__file__).parents[1])
    from benchmarks.closed_loop import run, static_start

    experiment, robot = identification(four_link, duration=0.2), four_link.with_parameters(LOOSE)
    start = static_start(equations(robot), experiment.reference[0])
    tip = run(_plant(peer, robot), robot, experiment, start)
    with LoadedFmu(four_link_fmu) as fmu:
        log = fmu.simulate(experiment, LOOSE)
    assert np.ptp(tip, axis=0).max() > 1e-3
    np.testing.assert_allclose(tip, log[["tip.x", "tip.y", "tip.z"]].to_numpy(), atol=2e-6)


def _plant(peer, robot):
    if peer == "mujoco":
        from benchmarks.mujoco_plant import MujocoPlant, Settings

        return MujocoPlant(robot, Settings("RK4", 0.5e-3))
    from benchmarks.pinocchio_plant import PinocchioPlant

    return PinocchioPlant(robot, 0.5e-3)
