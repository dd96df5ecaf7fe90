"""Torques that no log holds, from the robot's own loop: against the torque inside the FMU."""

from dataclasses import replace

import numpy as np
import pytest

import pyident as pi
from flexfmu.simulate import LoadedFmu
from flexmodels.coordinate import torque_of
from flexmodels.experiment import identification
from pyident.conditioning.weak_form import condition
from pyident.estimation.least_squares import solve_weighted
from pyident.logs.log import Log, LogError
from pyident.refinement.loop_torque import with_loop_torque
from pyident.regression.equations import Problem


@pytest.fixture(scope="module")
def recorded(four_link, four_link_fmu):
    """With noise on the encoders, which the controller reads."""
    with LoadedFmu(four_link_fmu) as fmu:
        noise = {name: 1e-6 for name in four_link.coordinates if name.endswith(".e")}
        frame = fmu.simulate_batch(identification(four_link), noise=noise, noise_seeds=[1])[0]
    return Log(frame, "recorded")


def _bare(log: Log, robot) -> Log:
    return replace(log, frame=log.frame.drop(columns=list(robot.torques)))


def test_the_controllers_answer_is_the_torque_in_the_fmu(four_link, recorded):
    (log,), notes = with_loop_torque(four_link, [_bare(recorded, four_link)])
    for name in four_link.torques:
        true = recorded.frame[name].to_numpy()
        off = log.frame[name].to_numpy() - true
        assert off.std() < 1e-6 * true.std(), name  # every sample, but for what the integral held
        assert np.abs(off.mean()) < 0.02 * true.std(), name  # by a plain regression
    assert "no torque" in notes[0]
    assert log.up_to_constant == four_link.torques


def _finds_the_same_without_torque(robot, log):
    with_torque, without = (
        pi.identify(robot, one, estimator="wls").robot.parameters for one in (log, _bare(log, robot))
    )
    for k in range(1, 5):
        for name in (f"joint{k}.coulomb", f"joint{k}.viscous", f"joint{k}.k[1]"):
            assert without[name] == pytest.approx(with_torque[name], rel=0.01), name


def test_identification_finds_the_same_without_torque(four_link, recorded):
    _finds_the_same_without_torque(four_link, recorded)


def test_a_log_may_begin_in_the_midst_of_a_motion(four_link, recorded):
    """There the integral holds friction and what accelerates the arm, besides its weight."""
    late = replace(recorded, frame=recorded.frame.iloc[1500:].reset_index(drop=True))
    (log,), _ = with_loop_torque(four_link, [_bare(late, four_link)])
    for name in four_link.torques:
        off = (log.frame[name] - late.frame[name])[1:]  # what the first sample answers to came before the log
        assert off.std() < 1e-6 * late.frame[name].std(), name
        assert np.abs(off.mean()) < 0.02 * late.frame[name].std(), name
    _finds_the_same_without_torque(four_link, late)


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["wls", "iv"])
def test_no_equation_reads_a_free_constant(four_link, recorded, estimator):
    free = replace(recorded, up_to_constant=four_link.torques)
    shifted = replace(free, frame=free.frame.assign(**{n: free.frame[n] + 40.0 for n in four_link.torques}))
    one, other = (pi.identify(four_link, log, estimator=estimator).identified for log in (free, shifted))
    assert one.solution.rank == other.solution.rank
    np.testing.assert_allclose(other.solution.p, one.solution.p, rtol=1e-5, atol=1e-6)
    assert one.support["joint2.coulomb"] == "alone"


def test_what_centring_leaves_of_the_equations_is_a_constant_column_in_the_regression(four_link, recorded):
    """Frisch and Waugh: the same parameters as with a column of ones for every joint and log."""
    free = condition(replace(recorded, up_to_constant=four_link.torques), four_link)
    p = solve_weighted(Problem(four_link, (free,)).reduced()).p
    full = Problem(four_link, (replace(free, free=()),))
    A, y = (np.concatenate(parts) for parts in zip(*((A.copy(), y) for A, y in full.blocks()), strict=True))
    for row in range(len(four_link.joints)):
        ones = free.use[:, row]
        assert np.abs(ones @ free.used(row, free.target[:, row])) < 1e-6 * np.abs(free.target[:, row]).sum()
        left = y[:, row] - A[:, row] @ p
        constant = (ones @ left) / ones.sum()
        np.testing.assert_allclose(
            Problem(four_link, (free,)).residuals(p)[0][:, row], left - constant * ones, atol=1e-8
        )


def test_what_the_log_does_not_tell_is_said(four_link, recorded):
    bare = _bare(recorded, four_link)
    blind = replace(bare, frame=bare.frame.drop(columns="joint2.tau_ff"))
    with pytest.raises(LogError, match=r"neither torques nor joint2\.tau_ff"):
        with_loop_torque(four_link, [blind])
    rare = replace(bare, frame=bare.frame.iloc[::2].reset_index(drop=True))
    with pytest.raises(LogError, match=r"not those of the controller"):
        with_loop_torque(four_link, [rare])


def test_measured_torques_stay(four_link, recorded):
    some = replace(recorded, frame=recorded.frame.drop(columns=torque_of(2)))
    assert with_loop_torque(four_link, [recorded, some]) == ((recorded, some), ())
