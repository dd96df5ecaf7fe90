"""The physically consistent parameters nearest to a solution, against closed forms."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest
from analytic_joint import COULOMB, INERTIA, VISCOUS, analytic_log, free_joint
from studies.rigid_arm.arm import arm

from flexmodels.link import LINK_PARAMETERS, Link
from pyident.conditioning.motion import Motion
from pyident.conditioning.weak_form import condition
from pyident.estimation.base_parameters import BaseParameter
from pyident.estimation.identify import impossible
from pyident.estimation.least_squares import residual_squares, solve_weighted
from pyident.estimation.physical import _without_rounding, consistent, lower_bounds
from pyident.logs.log import Log, LogError
from pyident.regression.equations import Problem
from pyident.regression.regressor import regressor


@pytest.fixture(scope="module")
def fitted():
    robot = free_joint()
    problem = Problem(robot, (condition(analytic_log(torque_noise=0.5), robot),))
    reduced = problem.reduced()
    return robot, reduced, solve_weighted(reduced)


def _with(solution, reduced, **values):
    p = solution.p.copy()
    for name, value in values.items():
        p[reduced.columns.index(f"joint1.{name}")] = value
    return replace(solution, p=p)


def _pseudo_inertia(values):
    """J of Wensing, Kim and Slotine (2018): [[Σ, ms], [msᵀ, m]], Σ = tr(I)/2 − I."""
    m, x, y, z, xx, xy, xz, yy, yz, zz = values
    rotational = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    out = np.zeros((4, 4))
    out[:3, :3] = np.trace(rotational) / 2 * np.eye(3) - rotational
    out[:3, 3] = out[3, :3] = x, y, z
    out[3, 3] = m
    return out


def test_what_the_data_determine_is_kept(fitted):
    robot, reduced, solution = fitted
    p = dict(zip(reduced.columns, consistent(robot, reduced, solution), strict=True))
    inertia = p["joint1.J_m"] + p["link1.J[zz]"]
    assert inertia == pytest.approx(INERTIA, rel=0.02)
    assert p["joint1.viscous"] == pytest.approx(VISCOUS, rel=0.05)
    assert p["joint1.coulomb"] == pytest.approx(COULOMB, rel=0.1)


def test_what_the_data_leave_open_is_a_real_body(fitted):
    robot, reduced, solution = fitted
    p = dict(zip(reduced.columns, consistent(robot, reduced, solution), strict=True))
    body = _pseudo_inertia([p[f"link1.{name}"] for name in LINK_PARAMETERS])
    assert np.linalg.eigvalsh(body).min() > 0


def test_a_negative_level_goes_to_its_bound_and_takes_its_neighbours_along(fitted):
    """One active bound: p = p̂ − C[:, i] p̂_i / C_ii in the metric of the covariance (Lagrange)."""
    robot, reduced, solution = fitted
    shifted = _with(solution, reduced, coulomb=-0.3)
    found = consistent(robot, reduced, shifted)
    spread = solution.seen / solution.singular_values[: solution.rank] / solution.scale[:, None]
    C = spread @ spread.T
    i, j = (reduced.columns.index(f"joint1.{name}") for name in ("coulomb", "viscous"))
    assert found[i] == pytest.approx(0.0, abs=1e-9)
    assert found[j] == pytest.approx(shifted.p[j] + C[j, i] / C[i, i] * 0.3, rel=1e-3)


def test_bounds_are_those_of_the_laws():
    bounds = lower_bounds(free_joint())
    assert bounds == {"joint1.J_m": 0.0, "joint1.coulomb": 0.0, "joint1.viscous": 0.0}


def test_where_the_solver_gives_up_the_user_is_sent_to_the_log(fitted, monkeypatch):
    import cvxpy as cp

    def gives_up(*_, **__):
        raise cp.SolverError("numbers too far apart")

    monkeypatch.setattr(cp.Problem, "solve", gives_up)
    with pytest.raises(LogError, match="gave up; `pyident log inspect` shows"):
        consistent(*fitted)


def hobby_arm():
    """Six axes of a hand's length and gram; the first is upright but for the digits of a file."""
    robot, size, tilt = arm(), 0.2, 4e-6
    powers = {"m": 3, "ms": 4, "J": 5}
    links = [
        Link.of_values(
            {name: value * size ** powers[name.split("[")[0]] for name, value in link.values.items()}
        )
        for link in robot.links
    ]
    joints = [replace(joint, origin=tuple(size * np.array(joint.origin))) for joint in robot.joints]
    joints[0] = replace(joints[0], x=(tilt, 0.0, float(np.sqrt(1 - tilt**2))), y=(0.0, 1.0, 0.0))
    tip = tuple(size * np.array(robot.tip))
    return replace(robot, joints=tuple(joints), links=tuple(links), tip=tip)


def test_what_acts_next_to_nothing_does_not_stop_the_solver():
    robot, rng = hobby_arm(), np.random.default_rng(1)
    time = np.arange(0, 15, 4e-3)
    omega, size, phase = rng.uniform(1, 4, (6, 4)), rng.uniform(0.1, 0.3, (6, 4)), rng.uniform(0, 6, (6, 4))
    angle = time[:, None, None] * omega + phase
    q = (size * np.sin(angle)).sum(axis=2)
    rates = (size * omega * np.cos(angle)).sum(axis=2), -(size * omega**2 * np.sin(angle)).sum(axis=2)
    own = {".coulomb": 0.05, ".viscous": 0.05, ".J_m": 0.02}
    values = robot.linear_parameters | {f"joint{k}{n}": v for k in range(1, 7) for n, v in own.items()}
    p = np.array([values[name] for name in robot.linear_parameters])
    tau = regressor(robot, Motion(q, *rates, np.zeros_like(q), time)).matrix @ p
    tau += 0.01 * tau.std(axis=0) * rng.standard_normal(tau.shape)
    encoders = q + 1e-6 * rng.standard_normal(q.shape)
    columns = {"time": time} | {f"joint{k + 1}.e": encoders[:, k] for k in range(6)}
    columns |= {f"joint{k + 1}.tau": tau[:, k] for k in range(6)}
    log = Log.from_frame(pd.DataFrame(columns), "hobby")
    reduced = Problem(robot, (condition(log, robot),)).reduced()
    solution = solve_weighted(reduced)
    found = dict(zip(reduced.columns, consistent(robot, reduced, solution), strict=True))
    for k in range(1, 7):
        body = _pseudo_inertia([found[f"link{k}.{name}"] for name in LINK_PARAMETERS])
        assert np.linalg.eigvalsh(body).min() > 0
        assert found[f"joint{k}.coulomb"] == pytest.approx(0.05, rel=0.1)
    left = np.sqrt(residual_squares(reduced, np.array([found[name] for name in reduced.columns])))
    least = np.sqrt(residual_squares(reduced, solution.p))
    assert np.all(left < 1.05 * least)


def test_a_sum_of_masses_below_zero_is_told():
    """Beyond chance alone, and of sums alone that no body has below zero."""
    masses, moment = ((1.0, "link3.m"), (1.0, "link4.m")), ((1.0, "link3.m"), (-2.0, "link4.ms[x]"))
    found = [BaseParameter(masses, -1.9, 0.01), BaseParameter(moment, -5.0, 0.01)]
    told = impossible(cast(Any, SimpleNamespace(base=found)))
    assert len(told) == 1
    assert "the logs ask for link3.m + 1 link4.m = -1.9 ± 0.02: a wrong sign" in told[0]
    chance = [BaseParameter(masses, -0.04, 0.01), BaseParameter(masses, -1.9, np.nan)]
    assert impossible(cast(Any, SimpleNamespace(base=chance))) == ()


def test_a_body_that_a_solver_leaves_a_little_below_zero_is_made_one():
    """A file with such a body was written, and refused when it was read."""
    names = [f"link1.{name}" for name in LINK_PARAMETERS]
    inertia = {"link1.m": 52.0, "link1.J[xx]": 31.5, "link1.J[yy]": 31.5, "link1.J[zz]": -2e-7}
    p = _without_rounding(np.array([inertia.get(name, 0.0) for name in names]), names, 1)
    assert dict(zip(names, p, strict=True))["link1.J[zz]"] >= 0
    np.testing.assert_allclose(p, [inertia.get(name, 0.0) for name in names], atol=1e-6)
