"""Many runs in one call are the runs one by one."""

from dataclasses import replace

import numpy as np
import pytest

from flexfmu.batch.binary import BatchBinary
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import identification
from flexmodels.inputs import Experiment, SimulationError

NOISE = {"joint1.e": 2e-6, "joint2.e": 2e-6, "joint3.eps[1]": 1e-6}


@pytest.fixture(scope="module")
def plan(four_link):
    return identification(four_link, duration=0.4)


@pytest.fixture(scope="module")
def loaded(four_link_fmu):
    with LoadedFmu(four_link_fmu) as fmu:
        yield fmu


def test_one_run_is_the_run_through_fmpy(loaded, plan):
    (frame,) = loaded.simulate_batch(plan)
    alone = loaded.simulate(plan)
    assert list(frame) == list(alone)
    np.testing.assert_array_equal(frame, alone)


def test_side_by_side_is_one_after_the_other(loaded, plan):
    """Vectors of runs round otherwise (fused operations); each run has its own friction events."""
    sets = [{"joint1.coulomb": 2.0 * i, "link3.m": 5.0 + i} for i in range(11)]
    frames = loaded.simulate_batch(plan, sets, NOISE, range(11))
    for i in (0, 4, 10):
        (alone,) = loaded.simulate_batch(plan, [sets[i]], NOISE, [i])
        difference = np.abs(frames[i] - alone).max()
        assert difference.filter(regex="tip").max() < 1e-9
        assert difference.filter(regex=r"\.e").max() < 1e-9
    assert np.abs(frames[0]["tip.x"] - frames[10]["tip.x"]).max() > 1e-4


def test_the_controller_sees_the_noise(loaded, plan):
    """By hand: a PID of r - (e + noise) is one of (r - noise) - e; at a deformation noise stays outside."""
    (noisy,) = loaded.simulate_batch(plan, noise=NOISE, noise_seeds=[5])
    rng = np.random.default_rng(5)
    added = {name: sigma * rng.standard_normal(len(plan.time)) for name, sigma in NOISE.items()}
    seen = np.zeros_like(plan.reference)
    seen[:, 0], seen[:, 1] = added["joint1.e"], added["joint2.e"]
    start = {f"joint{k}.start_error": seen[0, k - 1] for k in (1, 2)}
    by_hand = loaded.simulate(Experiment(plan.time, plan.reference - seen, plan.feedforward), start)
    for name in ("joint1.e", "joint3.eps[1]"):
        np.testing.assert_allclose(noisy[name], by_hand[name] + added[name], rtol=0, atol=1e-10)
    np.testing.assert_allclose(noisy["joint1.r"], plan.reference[:, 0])
    np.testing.assert_allclose(noisy["joint2.tau"], by_hand["joint2.tau"], atol=1e-3)


def test_runs_of_different_experiments_and_lengths_are_each_their_own(loaded, plan, four_link):
    """Two that share their times go side by side, the third cannot; the answers come in the order asked."""
    short = identification(four_link, duration=0.2)
    slower = replace(plan, reference=0.5 * plan.reference, feedforward=0.7 * plan.feedforward)
    sets = [{"joint1.coulomb": 3.0}, {"joint1.coulomb": 5.0}, {"joint1.coulomb": 7.0}]
    told: list[float] = []
    frames = loaded.simulate_batch([plan, short, slower], sets, progress=told.append)
    for frame, experiment, values in zip(frames, (plan, short, slower), sets, strict=True):
        alone = loaded.simulate(experiment, values)
        assert len(frame) == len(alone)
        assert np.abs(frame - alone).filter(regex=r"tip|\.e|\.r").max().max() < 1e-9
    assert told == sorted(told)


def test_samples_between_rows_are_taken(loaded, plan):
    """Rows of 20 ms, samples of 4 ms: the inputs between rows are linear, as through FMPy."""
    coarse = Experiment(plan.time[::5], plan.reference[::5], plan.feedforward[::5])
    (frame,) = loaded.simulate_batch(coarse)
    np.testing.assert_allclose(frame["tip.x"], loaded.simulate(coarse)["tip.x"], rtol=0, atol=1e-12)


def test_bad_questions_are_answered_with_a_sentence(loaded, plan):
    with pytest.raises(SimulationError, match=r"joint1\.coulomb = -1 must be at least 0"):
        loaded.simulate_batch(plan, [{"joint1.coulomb": -1.0}])
    with pytest.raises(SimulationError, match="no variable joint9"):
        loaded.simulate_batch(plan, [{"joint9.coulomb": 1.0}])
    with pytest.raises(SimulationError, match="left the finite numbers"):
        loaded.simulate_batch(plan, [{"solver.step": 4e-3}])
    with pytest.raises(SimulationError, match="do not match"):
        loaded.simulate_batch(plan, [{}, {}], NOISE, [1, 2, 3])
    with pytest.raises(SimulationError, match="2 experiments and 3 noise seeds do not match"):
        loaded.simulate_batch([plan, plan], noise=NOISE, noise_seeds=[1, 2, 3])


def test_a_run_whose_friction_chatters_is_ended(loaded, four_link):
    """At rest a hinge that no step follows shakes what friction holds; it would take hours for minutes."""
    time = np.arange(0.0, 4.0, 0.004)
    rest = Experiment(time, np.zeros((len(time), 4)), np.zeros((len(time), 4)))
    light = {"link1.J[zz]": 1.3e-4, "link1.J[yz]": 0.0, "joint2.d[3]": 17.0, "solver.step": 1e-4}
    usual = four_link.parameters
    with pytest.raises(SimulationError, match="run 1: friction chatters"):
        loaded.simulate_batch(rest, [{name: usual.get(name, 1e-3) for name in light}, light])
    (held,) = loaded.simulate_batch(rest)
    assert np.ptp(held["joint4.e"]) < 1e-4


def test_the_binary_tells_what_it_is(loaded):
    with BatchBinary(loaded.library) as binary:
        assert (binary.inputs, binary.joints) == (8, 4)
        assert binary.width in (1, 4, 8)


def test_a_look_sees_each_run_grow_and_may_end_them(loaded, plan):
    """The runs' own rows; an FMU's error is not what it raises."""
    seen: dict[int, list[int]] = {0: [], 1: []}
    whole = loaded.simulate_batch(plan, [{"joint1.coulomb": c} for c in (2.0, 5.0)])

    def look(number, frame):
        seen[number].append(len(frame))
        assert frame["joint2.e"].iloc[-1] == whole[number]["joint2.e"].iloc[len(frame) - 1]
        if len(frame) > 60:
            raise KeyError(number)

    with pytest.raises(KeyError):
        loaded.simulate_batch(plan, [{"joint1.coulomb": c} for c in (2.0, 5.0)], look=look)
    assert seen[0][0] == 1
    assert 60 < seen[0][-1] < len(plan.time)
