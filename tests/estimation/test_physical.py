"""The physically consistent parameters nearest to a solution, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_joint import COULOMB, INERTIA, VISCOUS, analytic_log, free_joint

from flexmodels.link import LINK_PARAMETERS
from pyident.conditioning.weak_form import condition
from pyident.estimation.least_squares import solve_weighted
from pyident.estimation.physical import consistent, lower_bounds
from pyident.logs.log import LogError
from pyident.regression.equations import Problem


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


def test_a_problem_that_fails_in_one_scale_is_solved_in_the_other(fitted, monkeypatch):
    import cvxpy as cp

    solve, asked = cp.Problem.solve, []

    def infeasible_at_first(problem, **options):
        asked.append(problem)
        if len(asked) > 1:
            solve(problem, **options)

    there = consistent(*fitted)
    monkeypatch.setattr(cp.Problem, "solve", infeasible_at_first)
    names = fitted[1].columns
    again = dict(zip(names, consistent(*fitted), strict=True))
    assert len(asked) == 2
    for name in ("joint1.coulomb", "joint1.viscous"):
        assert again[name] == pytest.approx(there[names.index(name)], rel=1e-3)
