"""The peers of the benchmark simulate the same arm as our FMU; their speed is not a test."""

from pathlib import Path

import numpy as np
import pytest
from one_joint import one_joint

from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import identification
from flexmodels.mechanics.plant import equations

LOOSE = {f"joint{k}.coulomb": 0.0 for k in range(1, 5)}


@pytest.mark.parametrize("peer", ["mujoco", "pinocchio"])
def test_a_peer_moves_the_tip_as_our_fmu_does(four_link, four_link_fmu, peer, monkeypatch):
    pytest.importorskip(peer, reason=f"{peer} is not installed, so the benchmark leaves it out")
    monkeypatch.syspath_prepend(Path(__file__).parents[1])
    from benchmarks.peers.closed_loop import run, static_start

    experiment, robot = identification(four_link, duration=0.2), four_link.with_parameters(LOOSE)
    start = static_start(equations(robot), experiment.reference[0])
    tip = run(_plant(peer, robot), robot, experiment, start)
    with LoadedFmu(four_link_fmu) as fmu:
        log = fmu.simulate(experiment, LOOSE)
    assert np.ptp(tip, axis=0).max() > 1e-3
    np.testing.assert_allclose(tip, log[["tip.x", "tip.y", "tip.z"]].to_numpy(), atol=2e-6)


def _plant(peer, robot):
    if peer == "mujoco":
        from benchmarks.peers.mujoco_plant import MujocoPlant, Settings

        return MujocoPlant(robot, Settings("RK4", 0.5e-3))
    from benchmarks.peers.pinocchio_plant import PinocchioPlant

    return PinocchioPlant(robot, 0.5e-3)


def test_phi_is_measured_and_is_pinocchios(monkeypatch):
    pytest.importorskip("pinocchio", reason="the peer is not installed")
    monkeypatch.syspath_prepend(Path(__file__).parents[1])
    from benchmarks import regressor

    monkeypatch.setattr("benchmarks.peers.pinocchio_loop.cpp_speed", lambda *_: "not in a test")
    found = regressor.rows([1, 4], samples=400)
    tools = ["pyident, compiled", "Pinocchio, loop in Python"]
    assert [row["tool"] for row in found if row["joints"] == 1] == tools
    assert all(row["samples per second"] > 0 for row in found)
    assert len(regressor.with_joints(regressor.load_robot("four_link"), 12).coordinates) == 48


def test_the_solutions_that_are_compared_are_one(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1])
    from benchmarks import solve

    found = solve.rows(2000, [3000], tools=("ours", "numpy lstsq"))
    assert [row["tool"] for row in found] == ["ours", "numpy lstsq", "ours, from disk"]
    assert found[1]["differs from ours"] < 1e-8
    assert all(row["seconds"] > 0 for row in found)


def test_a_start_is_measured(monkeypatch):
    """What takes CPU counts as such; how much is no test."""
    monkeypatch.syspath_prepend(Path(__file__).parents[1])
    from benchmarks.startup import CASES, PEER, cpu_seconds, measured

    idle, busy = (cpu_seconds(("-c", f"sum(range({n}))")) for n in (1, 20_000_000))
    assert busy > idle
    monkeypatch.setattr("benchmarks.startup.CASES", {name: CASES[name] for name in list(CASES)[:2]})
    found = measured(0)
    assert found["what"].to_list() == [PEER]
    assert found["ratio to numpy, pandas"].to_list() == [1.0]


def test_the_ways_from_logs_to_parameters_are_measured_on_the_same_logs(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1])
    from benchmarks import identification

    monkeypatch.setattr(identification, "load_robot", lambda _: one_joint())
    monkeypatch.setattr(identification, "LEVEL", 0.0)
    found = identification.rows(seconds=1.0, verdict=False)
    assert [row["way"] for row in found] == ["lstsq", "wls", "iv", "oe"]
    assert found[0]["times lstsq [CPU]"] == 1.0
    robot, given = one_joint(), identification.logs(one_joint(), 1.0)
    p = dict(zip(robot.linear_parameters, identification.by_lstsq(robot, given), strict=True))
    assert p["joint1.viscous"] == pytest.approx(robot.parameters["joint1.viscous"], rel=1e-2)
