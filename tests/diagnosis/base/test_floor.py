"""The floor: errors that no model is free of, in every replica; and what stands out above it."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from one_joint import PERIOD, one_joint
from six_axis_logs import arm, made

from flexmodels.files.robot_file import load_robot
from flexmodels.robot import Robot
from flexmodels.settings.processing import Processing
from pyident.conditioning.reversals.rest import STANDSTILL
from pyident.diagnosis.base.discrepancy import inexact
from pyident.diagnosis.base.projection import Base
from pyident.diagnosis.base.residual_over_floor import EDGES, Examination, Region, examine
from pyident.diagnosis.base.setting import in_closed_loop, set_up, workers_of
from pyident.diagnosis.notes import in_doubt
from pyident.diagnosis.search.gate import Refusal
from pyident.diagnosis.search.search import Search
from pyident.logs.log import Log
from pyident.regression.spectrum import Floor
from pyident.rules.rules import RULES, Rules
from pyident.simulation.fmu_runs import runs_here

TIME = np.arange(4000) * PERIOD


def _change(torque: np.ndarray, share: float, friction: float) -> np.ndarray:
    """Of the torque, along sin t; the robot's Coulomb friction is `friction` [N m]."""
    log = Log(pd.DataFrame({"time": TIME, "joint1.e": np.sin(TIME), "joint1.tau": torque}), "a log")
    robot = one_joint().with_parameters({"joint1.coulomb": friction})
    made = inexact(robot, log, share, seed=5)
    assert np.array_equal(made.frame["joint1.e"], log.frame["joint1.e"])
    return made.frame["joint1.tau"].to_numpy() - torque


def test_an_error_has_its_share_of_the_torque_and_none_of_its_mean():
    noise = np.random.default_rng(0).standard_normal(4000)
    assert np.std(_change(50 + noise, 1e-3, 0.0)) == pytest.approx(1e-3, rel=0.1)


def test_an_error_is_where_the_torque_is():
    power = np.abs(np.fft.rfft(_change(np.sin(2 * np.pi * 10 * TIME), 1e-3, 0.0))) ** 2
    f = np.fft.rfftfreq(4000, PERIOD)
    assert power[np.abs(f - 10) < 1].sum() > 0.99 * power.sum()


def test_friction_is_rounded_near_rest_alone_and_never_more_than_it_is():
    speed = np.cos(TIME)
    change = _change(np.zeros(4000), 0.0, 3.0)
    assert (change * speed <= 0).all()  # less friction
    assert 0.5 < np.abs(change).max() <= 3.0
    assert np.abs(change[np.abs(speed) > 0.1]).max() < 3e-3  # 7 % of the rms speed


def _over_floor(width: float, fall: float) -> float:
    """What an axis leaves of its floor where [processing] thins equations out, and a controller is not known.

    width   of the friction's rounding in the machine, of standstill [rad/s]
    fall    of its Coulomb friction over the log
    """
    thinned = Processing("central", cutoff=40.0, decimate=5)
    robot = load_robot("emps").with_settings(processing=thinned)
    rng, t = np.random.default_rng(0), np.arange(0, 20, 0.002)
    w, a, phase = 2 * np.pi * np.array([0.11, 0.23, 0.41, 0.9]), [0.3, 0.2, 0.15, 0.05], rng.uniform(0, 6, 4)
    S, C = np.sin(np.outer(t, w) + phase), np.cos(np.outer(t, w) + phase)
    v = C @ (a * w)
    dry = 35 * (1 - fall * t / t[-1]) * np.tanh(v / (width * STANDSTILL * np.sqrt(np.mean(v**2))))
    tau = -60 * S @ (a * w**2) + 90 * v + dry
    tau += 0.01 * np.std(tau) * rng.standard_normal(len(t))
    frame = pd.DataFrame(
        {"time": t, "joint1.e": S @ a + 1e-6 * rng.standard_normal(len(t)), "joint1.tau": tau}
    )
    setting = set_up(robot, [Log(frame, "log")])
    with workers_of(setting, runs_here) as workers:
        found = examine(setting, workers, lambda _: None, lambda *_: [])
    return float(np.sqrt(found.base.energy / found.floor_energies.sum()))


@pytest.mark.parametrize("width", [0.01, 0.2])
def test_reversals_neither_raise_the_floor_nor_stand_above_it_where_equations_are_thinned_out(width):
    assert 0.8 < _over_floor(width, 0.0) < 1.2
    assert _over_floor(width, 0.1) > 1.6


SAMPLES = 100
CALM, WILD = [1.0] * 20, [0.2] * 19 + [16.2]  # energy that each of 20 replicas leaves: on average 1


@dataclass(frozen=True)
class Fitted:
    continued: np.ndarray
    rules: Rules = RULES
    robot: Robot = field(default_factory=one_joint)


def search_of(
    residual: np.ndarray, in_bands: np.ndarray, replicas: np.ndarray, continued: float = 0.0
) -> Search:
    """Of one equation: residual (E,), in_bands (E, bands), what replicas leave on average (20, bands).

    continued   Hz: below, the noise is not measured
    """
    setting: Any = Fitted(np.array([[continued]]))
    more = ((0, 0), (0, len(EDGES) - in_bands.shape[1]))
    in_bands, replicas = np.pad(in_bands, more), np.pad(replicas, more)
    count, nothing = in_bands.sum(axis=0), np.zeros((20, 0))
    floor: Any = Floor(np.array([0.0, 20.0]), np.ones((1, 2)))
    base = Base(np.zeros(0), np.zeros((0, 0)), [], [residual[None]])
    examined: Any = ([], [], [], nothing, [], np.zeros((1, len(count))), replicas[:, None], count, np.ones(1))
    examination = Examination(setting, [floor], [], base, *examined)
    vars(examination)["bands"] = [in_bands]
    families: Any = None
    return Search(examination, families, base)


def standing_out(residual: np.ndarray, in_bands: np.ndarray, replicas: np.ndarray) -> bool:
    """Whether that equation does."""
    return bool(search_of(residual, in_bands, replicas).standing_out[0])


@pytest.mark.parametrize(
    ("energy", "replicas", "stands_out"),
    [(1.9, CALM, False), (2.1, CALM, True), (15.0, WILD, False), (17.0, WILD, True)],
)
def test_what_a_perfect_model_leaves_as_well_does_not_stand_out(energy, replicas, stands_out):
    residual = np.full(SAMPLES, np.sqrt(energy))
    assert standing_out(residual, np.ones((SAMPLES, 1)), np.reshape(replicas, (20, 1))) == stands_out


@pytest.mark.parametrize(("energy", "stands_out"), [(3.9, False), (4.1, True)])
def test_noise_of_other_bands_does_not_dilute_what_stands_out_in_one(energy, stands_out):
    """A tenth of the equations lies in a low band; all of them together hold 1.3 floors at most."""
    residual = np.ones(SAMPLES)
    residual[: SAMPLES // 10] = np.sqrt(energy)
    low = np.arange(SAMPLES) < SAMPLES // 10
    assert standing_out(residual, np.column_stack([low, ~low]).astype(float), np.ones((20, 2))) == stands_out


@pytest.mark.parametrize(("energy", "stands_out"), [(4.1, False), (192.0, False), (194.0, True)])
def test_a_noise_may_rise_where_it_was_not_measured(energy, stands_out):
    """As 1/f² to 1 Hz and as 1/f below: 64 times at the middle of the band up to 0.5 Hz."""
    residual = np.ones(10 * SAMPLES)
    residual[:20] = np.sqrt(energy)
    low = np.arange(10 * SAMPLES) < 20
    bands = np.column_stack([low, ~low]).astype(float)
    search = search_of(residual, bands, np.ones((20, 2)), 4.0)
    assert bool(search.standing_out[0]) == stands_out
    place: Any = SimpleNamespace(state="in_order")
    near: Any = SimpleNamespace(effect="stribeck", joint=1)
    refused = [Refusal(near, Region((0,), (0,)), share, None, f"{share:g} %") for share in (30.0, 60.0)]
    doubts = list(in_doubt(search, [place], refused))
    assert bool(doubts) == (not stands_out)
    unexplained: Any = SimpleNamespace(state="unexplained")
    assert not list(in_doubt(search, [unexplained], refused))
    if doubts:
        assert f"joint1, motor side ({np.sqrt(energy):.2g} times from 0 to 0.5 Hz)" in doubts[0]
        assert "; stribeck at joint1 comes nearest, but 60 %;" in doubts[0]
    assert standing_out(residual, bands, np.ones((20, 2)))


def test_in_closed_loop_replicas_have_the_noise_of_rounding():
    """Along the measured motion they are rounded; under a controller that stands in, noise does it."""
    step, log = 1e-3, made(arm(), 0, duration=10.0)
    rounded = {f"joint{k}.e": step * np.round(log.frame[f"joint{k}.e"] / step) for k in range(1, 7)}
    logs = [replace(log, frame=log.frame.assign(**rounded))]
    along = set_up(arm(), logs)
    noise = in_closed_loop(along, logs).noise
    for name in rounded:
        assert along.noise[name] < 0.7 * step / np.sqrt(12)
        assert noise[name] == pytest.approx(step / np.sqrt(12), rel=0.25)
