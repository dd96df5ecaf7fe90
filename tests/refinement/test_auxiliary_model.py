"""Instrumental variables: against statsmodels, against drawn noise, and on a noisy log of a simulated arm."""

from contextlib import contextmanager

import numpy as np
import pytest
from scipy.signal import lfilter
from statsmodels.sandbox.regression.gmm import IV2SLS
from two_link_logs import in_process, loaded, two_link

from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.fading import fading
from pyident.conditioning.weak_form import condition
from pyident.estimation.identify import identify
from pyident.estimation.instrumental_variables import Rows, solve_instrumental
from pyident.logs.log import Log
from pyident.refinement.auxiliary_model import NAME, START, identify_by_instruments
from pyident.refinement.identifications import IDENTIFICATIONS
from pyident.refinement.instruments.noise_scatter import noise_scatter
from pyident.refinement.instruments.residual_spectrum import spectral
from pyident.regression.reduced import reduce
from pyident.regression.regressor import regressor
from pyident.simulation.replica import with_noise

NOISE = 2e-5  # rad: stiffnesses come out far too small by least squares


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("instruments")


@pytest.fixture(scope="module")
def logs(folder) -> list[Log]:
    """Six seconds without noise, and with encoder noise in the loop."""
    robot, time = two_link(), np.arange(1500) / 250
    lines, rng = np.linspace(0.5, 40, 60), np.random.default_rng(7)
    swing = [0.6 * (1 - np.cos(2 * np.pi * time / period)) for period in (2.7, 3.4)]
    phases = rng.uniform(0, 2 * np.pi, (2, 60))
    waves = [np.cos(2 * np.pi * np.outer(time, lines) + p).sum(axis=1) for p in phases]
    plan = Experiment(time, np.column_stack(swing), np.column_stack(waves) * (4.0, 1.5))
    noise = {
        name: (NOISE if name.endswith(".e") else NOISE / 2) * rng.standard_normal(len(time))
        for name in robot.coordinates
    }
    with loaded(robot, folder) as fmu:
        return [
            Log(fmu.simulate(plan), "quiet"),
            Log(with_noise(lambda made: fmu.simulate(made), plan, noise), "noisy"),
        ]


@pytest.fixture(scope="module")
def found(folder, logs):
    return identify_by_instruments(two_link(), [logs[1]], in_process)


def errors(robot: Robot, p: np.ndarray, kinds: tuple[str, ...]) -> np.ndarray:
    true = robot.linear_parameters
    return np.array([abs(v / true[n] - 1) for n, v in zip(true, p, strict=True) if n.split(".")[1] in kinds])


def test_the_algebra_is_that_of_statsmodels():
    rng = np.random.default_rng(0)
    signal = rng.normal(size=(400, 2, 3))
    A, Z = signal + 0.5 * rng.normal(size=signal.shape), signal + 0.5 * rng.normal(size=signal.shape)
    y = signal @ [1.0, -2.0, 3.0] + 0.1 * rng.normal(size=(400, 2))
    weights = np.array([1.0, 3.0])
    reduced = reduce([(A, y)], ("a", "b"), ("u", "v", "w"))

    def rows():
        return [Rows(A, Z, y, np.ones_like(y))]

    ours = solve_instrumental(rows, reduced, weights, spectral(rows, weights))
    weighted = [(x * weights[:, None]).reshape(-1, 3) for x in (A, Z)]
    theirs = IV2SLS((y * weights).ravel(), weighted[0], weighted[1]).fit()
    np.testing.assert_allclose(ours.p, theirs.params, rtol=1e-9)
    np.testing.assert_allclose(ours.std, theirs.bse, rtol=0.35)  # theirs: residuals of one size


def test_intervals_hold_where_a_joint_rests_half_the_time():
    """Coloured noise on an axis that moves for a second and rests for one: the spread over 300 logs."""
    rng, N = np.random.default_rng(1), 4000
    time = np.arange(N) * 0.01
    share = (np.sin(np.pi * time) > 0).astype(float)[:, None]
    Z = np.stack([np.sin(7 * time), np.cos(3 * time), np.ones(N)], axis=1)[:, None, :] * share[..., None]
    sums, said = [], []
    for _ in range(300):
        noise = np.asarray(lfilter([1.0], [1.0, -0.6], rng.normal(size=N)))[:, None] * share
        rows = Rows(Z, Z, noise, share)
        sums.append(rows.moments(noise, np.ones(1)))
        said.append(spectral(lambda rows=rows: [rows], np.ones(1))(np.eye(3), np.zeros(3)).diagonal())
    np.testing.assert_allclose(np.mean(said, axis=0), np.var(sums, axis=0), rtol=0.2)


def test_intervals_hold_where_parameters_are_many_in_a_few_bins():
    """24 of a motion below 2 Hz, of 20 s: what they leave there is much less than the noise was."""
    rng, N, P = np.random.default_rng(2), 2000, 24
    time = np.arange(N) * 0.01
    waves = [wave(2 * np.pi * f * time) for f in rng.uniform(0.1, 2, P // 2) for wave in (np.sin, np.cos)]
    Z, share = np.linalg.qr(np.column_stack(waves))[0][:, None, :], np.ones((N, 1))
    errors, bare, said = [], [], []
    for _ in range(200):
        rows = Rows(Z, Z, rng.normal(size=(N, 1)), share)
        p = rows.moments(rows.y, np.ones(1))
        errors.append(p)
        for kept, fitted in ((bare, None), (said, np.eye(P))):
            kept.append(
                spectral(lambda rows=rows: [rows], np.ones(1), fitted=fitted)(np.eye(P), p).diagonal()
            )
    assert np.mean(bare) < 0.8 * np.var(errors)
    z = np.abs(errors) / np.sqrt(said)
    assert 0.94 < np.mean(z < 1.96) < 0.995


def test_the_mask_fades_before_it_closes():
    use = np.ones((100, 1))
    use[40:50] = 0
    share = fading(use, 5)[:, 0]
    assert (share[40:50] == 0).all()
    assert share[0] < 0.05
    assert share[20] == pytest.approx(1)
    assert np.abs(np.diff(share)).max() < 0.3


def test_intervals_carry_the_noise_as_drawn_noise_does(logs):
    """400 draws of noise on a quiet log: the spread of the sums against instruments."""
    robot, log = two_link(), logs[0]
    part, p = condition(log, robot), np.array(list(two_link().linear_parameters.values()))
    Z = regressor(robot, part.motion).matrix
    rows = Rows(Z, Z, part.target, fading(part.use))
    weights = 1 / np.maximum(np.abs(part.target).max(axis=0), 1.0)
    turn = np.diag(1 / np.maximum(np.linalg.norm(Z, axis=(0, 1)), 1e-12))
    noise = {"joint1.e": 2e-6, "joint2.e": 1e-6, "joint1.eps[1]": 3e-6}
    ours = noise_scatter(robot, part, rows, p, weights, turn, noise, log.period)
    rng, sums = np.random.default_rng(1), []
    for _ in range(400):
        frame = log.frame.copy()
        for name, sigma in noise.items():
            frame[name] += sigma * rng.standard_normal(len(frame))
        drawn = condition(Log(frame, "drawn"), robot)
        change = (regressor(robot, drawn.motion).matrix - Z) @ p
        sums.append(np.einsum("ncp,nc->p", Z, change * rows.share * weights**2) @ turn)
    spread = np.std(sums, axis=0)
    strong = spread > 1e-6 * spread.max()
    assert strong.sum() > 15
    np.testing.assert_allclose(np.sqrt(np.diag(ours))[strong], spread[strong], rtol=0.15)


def test_noise_that_ruins_least_squares_leaves_the_instruments_alone(found, logs):
    robot = two_link()
    plain = identify(robot, [logs[1]])
    ours, theirs = (errors(robot, p, ("k[1]", "J_m")) for p in (found.solution.p, plain.solution.p))
    assert theirs.max() > 0.1
    assert ours.max() < theirs.max() / 10
    alone = np.isfinite(found.solution.std)
    fast = {f"joint{k}.d[{i}]" for k in (1, 2) for i in (1, 2, 3)} & {
        name for name, told in zip(found.reduced.columns, alone, strict=True) if not told
    }
    assert [b.expression for b in found.base if np.isnan(b.std)] == sorted(fast)
    assert all(name in found.notes[-1] for name in fast)
    assert 0 < len(fast) < 6
    true = np.array(list(robot.linear_parameters.values()))
    z = (found.solution.p - true)[alone] / found.solution.std[alone]
    assert np.mean(np.abs(z) < 1.96) > 0.8
    assert np.sqrt(np.mean(z**2)) > 0.3  # nor are the intervals vast
    assert found.estimator == NAME


def test_rounds_that_end_unsettled_give_no_intervals_and_say_so(logs, monkeypatch):
    monkeypatch.setattr("pyident.refinement.auxiliary_model._ROUNDS", 1)
    result = identify_by_instruments(two_link(), [logs[1]], in_process)
    assert "had not settled after 1 rounds" in " ".join(result.notes)
    assert all(b.std != b.std for b in result.base)


def test_what_cannot_be_simulated_gets_no_intervals_and_says_so(logs):
    @contextmanager
    def broken(robot: Robot):
        raise SimulationError("it rings")
        yield

    result = identify_by_instruments(two_link(), [logs[1]], broken)
    assert result.estimator == START
    (note,) = [note for note in result.notes if "cannot be simulated (it rings)" in note]
    assert "no intervals" in note
    assert all(b.std != b.std for b in result.base)
    assert all(entry["std"] is None for entry in result.json()["parameters"].values())


@pytest.mark.parametrize("name", ["ols", "wls", "irls", "pe", "tls"])
def test_every_estimator_finds_a_quiet_log_and_says_its_name(name, logs, folder):
    robot = two_link()
    result = IDENTIFICATIONS[name](robot, [logs[0]], in_process)
    assert errors(robot, result.solution.p, ("coulomb", "J_m")).max() < 0.02
    assert ("least squares" in result.estimator) == (name != "pe")
    assert result.json()["estimator"] == result.estimator
