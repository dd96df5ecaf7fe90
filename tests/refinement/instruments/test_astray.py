"""A simulation that leaves the motion of its log is ended there, and never one that would have followed."""

import numpy as np
import pandas as pd
import pytest

from flexmodels.experiment import Experiment
from pyident.logs.log import Log
from pyident.refinement.instruments.missed import (
    FOLLOWS,
    NotFollowedError,
    astray,
    missed,
    require_followed,
)
from pyident.simulation.replica import Repeat

TIME = np.arange(2000) / 100
SWING = np.column_stack([np.sin(TIME), 0.3 * np.cos(2 * TIME)])


def frame(positions: np.ndarray) -> pd.DataFrame:
    return pd.DataFrame({"time": TIME, "joint1.e": positions[:, 0], "joint2.e": positions[:, 1]})


AGAIN = (Repeat(Log(frame(SWING), "log"), Experiment(TIME, SWING, 0 * SWING)),)


def ends(made: pd.DataFrame) -> int | None:
    """After how many samples it is ended."""
    look = astray(AGAIN)
    for samples in range(20, len(TIME) + 1, 20):
        try:
            look(0, made.iloc[:samples])
        except NotFollowedError:
            return samples
    return None


@pytest.mark.parametrize("size", [0.1, 0.15, 0.25, 0.4, 1.0, 10.0])
@pytest.mark.parametrize("seed", range(3))
def test_what_would_have_followed_goes_on(seed, size):
    walk = np.cumsum(np.random.default_rng(seed).standard_normal(SWING.shape), axis=0)
    made = frame(SWING + size * walk / walk.std(axis=0) * SWING.std(axis=0))
    follows = missed(AGAIN, [made]) < FOLLOWS
    assert (ends(made) is None) == follows


def test_one_that_explodes_is_ended_where_it_does():
    gone = frame(SWING + np.column_stack([0 * TIME, np.expm1(30 * np.maximum(TIME - 4, 0)).clip(max=1e9)]))
    samples = ends(gone)
    assert samples is not None
    assert 4.0 < TIME[samples - 1] < 4.5
    with pytest.raises(NotFollowedError, match=r"joint2 .* leaves the motion of log within 4\.\d s"):
        astray(AGAIN)(0, gone.iloc[:450])


def test_the_joint_that_misses_most_is_named():
    made = frame(SWING * [1.05, 1.3])
    with pytest.raises(NotFollowedError, match=r"joint2 .* misses 30 % of its motion in log"):
        require_followed(AGAIN, [made])
    require_followed(AGAIN, [frame(SWING * [1.05, 1.1])])
