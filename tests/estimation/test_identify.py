from importlib import import_module

import numpy as np
import pytest

from flexmodels.files.robot_file import load_robot
from pyident.conditioning.filters import thin
from pyident.conditioning.weak_form import central_differences, hat_means
from pyident.estimation.identify import identify
from pyident.estimation.least_squares import solve, solve_weighted
from pyident.logs.log import Log
from pyident.regression.reduced import reduce


def test_central_differences_are_of_eighth_order():
    def error(period):
        time = np.arange(-40, 41) * period
        _, dq, ddq = central_differences(np.sin(3 * time)[:, None], period)
        time = time[4:-4, None]
        return np.abs(dq - 3 * np.cos(3 * time)).max(), np.abs(ddq + 9 * np.sin(3 * time)).max()

    coarse, fine = error(0.16), error(0.08)
    assert np.log2(coarse[0] / fine[0]) == pytest.approx(8, abs=0.2)
    assert np.log2(coarse[1] / fine[1]) == pytest.approx(8, abs=0.2)


def test_hat_means_are_exact_between_jumps_of_the_acceleration():
    """A position whose acceleration jumps at every sample: the second difference is the hat's mean of it."""
    rng, period, fine = np.random.default_rng(2), 0.01, 200
    a = np.repeat(rng.normal(size=60), fine)
    dt = period / fine
    v = np.concatenate([[0], np.cumsum(a) * dt])
    q = np.concatenate([[0], np.cumsum((v[1:] + v[:-1]) / 2) * dt])
    mean, _, ddq = hat_means(q[::fine, None], period)
    held = a[::fine]
    np.testing.assert_allclose(
        ddq[:, 0], ((held[:-1] + held[1:]) / 2)[3 : 3 + len(ddq)], rtol=1e-6, atol=1e-6
    )
    hat = np.concatenate([np.arange(fine), fine - np.arange(fine)]) / fine**2
    at = [q[(i - 1) * fine : (i + 1) * fine] @ hat for i in range(4, 4 + len(mean))]
    np.testing.assert_allclose(mean[:, 0], at, atol=2e-2 * period**2)


def test_the_velocity_is_the_mean_under_the_hat():
    """Analytic signals: polynomials of degree 8 exactly, sines as sinc² of half a period's angle."""
    period, time = 0.004, 0.004 * np.arange(-12, 13)
    inner = time[4:-4]
    for degree in range(1, 9):
        _, mean, _ = hat_means((time[:, None] / 0.05) ** degree, period)
        powers = [(inner + side * period) ** (degree + 1) for side in (1, 0, -1)]
        exact = (powers[0] - 2 * powers[1] + powers[2]) / (degree + 1) / period**2 / 0.05**degree
        np.testing.assert_allclose(mean[:, 0], exact, rtol=1e-10, atol=1e-10 * np.abs(exact).max())
    for hertz, error in ((1.0, 1e-10), (5.0, 1e-8), (20.0, 1e-4), (50.0, 0.02)):
        omega = 2 * np.pi * hertz
        _, mean, _ = hat_means(np.sin(omega * time)[:, None], period)
        exact = omega * np.cos(omega * inner) * np.sinc(hertz * period) ** 2
        assert np.abs(mean[:, 0] - exact).max() < error * omega, hertz


def test_thinning_keeps_slow_signals_in_place():
    time = np.arange(4000) / 1000
    slow, fast = np.sin(2 * np.pi * 2 * time), np.sin(2 * np.pi * 90 * time)
    kept = thin((slow + fast)[:, None], 10)[:, 0]
    np.testing.assert_allclose(kept[20:-20], slow[::10][20:-20], atol=0.01)


def test_the_streamed_solution_is_numpys():
    rng = np.random.default_rng(1)
    A, p = rng.normal(size=(300, 2, 5)), np.array([1.0, -2.0, 3.0, 0.0, 5.0])
    A[:, :, 3] = A[:, :, 0] + A[:, :, 1]  # a column that can not be told from two others
    y = A @ p + 0.01 * rng.normal(size=(300, 2))
    blocks = ((A[i : i + 70], y[i : i + 70]) for i in range(0, 300, 70))
    solution = solve(reduce(blocks, ("a", "b"), tuple("vwxyz")))
    scale = np.linalg.norm(A.reshape(-1, 5), axis=0)
    expected = np.linalg.lstsq(A.reshape(-1, 5) / scale, y.ravel(), rcond=1e-10)[0] / scale
    np.testing.assert_allclose(solution.p, expected, rtol=1e-10)
    assert solution.rank == 4
    assert np.isinf(solution.std).tolist() == [True, True, False, True, False]
    np.testing.assert_allclose(solution.residual, 0.01, rtol=0.2)


@pytest.fixture(scope="module")
def found(four_link, identification_log):
    return identify(four_link, [identification_log])


def test_four_link_is_identified(four_link, found):
    true, new = four_link.parameters, found.robot.parameters
    for k in range(1, 5):
        assert new[f"joint{k}.k[1]"] == pytest.approx(true[f"joint{k}.k[1]"], rel=0.02)
    assert found.solution.rank == 71
    assert found.support["link1.m"] == "no"
    assert found.support["joint1.k[2]"] == "combination"
    assert found.support["joint1.k[1]"] == "alone"
    assert found.relative_error["all"] < 4
    content = found.json()
    assert set(content) >= {"parameters", "base_parameters", "rank", "relative_error_percent"}
    assert content["estimator"] == found.estimator
    assert len(content["base_parameters"]) == 71
    assert content["parameters"]["joint1.k[2]"]["std"] is None


def test_the_nominal_values_are_never_used(four_link, identification_log):
    """Identification from a robot file with quite other dynamic parameters gives the same numbers."""
    rng = np.random.default_rng(3)
    other = four_link.with_parameters({n: v * rng.uniform(0.5, 2) for n, v in four_link.parameters.items()})
    log = Log(identification_log.frame.head(1500), "short")
    a, b = (identify(robot, [log]).robot.parameters for robot in (four_link, other))
    assert list(a.values()) == list(b.values())


def test_the_identified_robot_is_physical(found):
    for link in found.robot.links:
        xx, xy, xz, yy, yz, zz = link.J
        J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        pseudo = np.zeros((4, 4))
        pseudo[:3, :3] = np.trace(J) / 2 * np.eye(3) - J
        pseudo[3, :3] = pseudo[:3, 3] = link.ms
        pseudo[3, 3] = link.m
        assert np.linalg.eigvalsh(pseudo).min() > 0
    laws = {name: value for name, value in found.robot.parameters.items() if name.startswith("joint")}
    assert min(laws.values()) >= 0


@pytest.mark.data
def test_emps_agrees_with_the_published_values(data, tmp_path, monkeypatch):
    """Free runs of two structures, hardly fitted, on the halves only: all of it takes minutes."""
    from pyident.sweep.studies import find_study

    study = find_study("emps")
    assert study is not None
    benchmark = import_module("pyident.sweep.studies.emps.benchmark")
    monkeypatch.setattr(benchmark, "STRUCTURES", benchmark.STRUCTURES[:2])
    monkeypatch.setattr(benchmark, "folds", lambda samples, folds=benchmark.folds: folds(samples)[:2])
    monkeypatch.setattr(import_module("pyident.sweep.studies.emps.structures"), "_ROUNDS", 2)
    rows = study(tmp_path, lambda _: None).rows
    published = [row for row in rows if row["goal"]]
    assert len(published) == 11
    assert [row["what"] for row in published if row["met"] != "yes"] == []
    assert len(rows) == 13
    assert load_robot(tmp_path / "benchmark.toml").name == "emps_benchmark"


def test_the_paper_study_meets_its_goals(tmp_path):
    from pyident.sweep.studies import find_study

    study = find_study("paper")
    assert study is not None
    result = study(tmp_path, lambda _: None)
    assert [row["what"] for row in result.rows if row["met"] == "no"] == []
    assert all(figure.stat().st_size > 10_000 for figure in result.figures)
    assert load_robot(tmp_path / "identified.toml").name == "four_link_identified"


def test_a_stiffness_is_not_weighted_away():
    """Twists of which a fifth is noise, under loads of 1000 N m and friction of which 800 N m is unknown."""
    samples, k = 5000, 2e6
    x, v, noise, unknown = np.random.default_rng(8).normal(size=(4, samples))
    A, y = np.zeros((samples, 2, 3)), np.zeros((samples, 2))
    A[:, 0, 0], A[:, 0, 1], A[:, 1, 0] = x, v, x
    A[:, 1, 2] = (-1000 * x + 500 * noise) / k
    y[:, 0] = 1000 * x + 200 * v + 800 * unknown
    found = solve_weighted(reduce([(A, y)], ("e", "eps"), ("load", "viscous", "k")))
    load, viscous, stiffness = found.p
    assert load > 400
    assert viscous == pytest.approx(200, rel=0.1)
    assert stiffness / load == pytest.approx(k / 1000 * 0.8, rel=0.03)  # 0.8: what the noise takes


def test_a_column_that_is_zero_is_in_no_direction_that_the_data_see():
    rng = np.random.default_rng(7)
    A = rng.normal(size=(300, 3, 6))
    A[:, :, [1, 4]] = 0.0
    A[:, 0, 2] = 0.0
    solution = solve(reduce([(A, rng.normal(size=(300, 3)))], ("a", "b", "c"), tuple("uvwxyz")))
    assert solution.rank == 4
    assert (solution.seen[[1, 4]] == 0).all()
    assert (solution.p[[1, 4]] == 0).all()
