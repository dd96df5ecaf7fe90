"""What stands in where nothing says how the torque of a log was made."""

from dataclasses import replace

import numpy as np
import pandas as pd
from one_joint import one_joint

from flexmodels.experiment import Experiment
from pyident.logs.log import Log
from pyident.refinement.instruments.stand_in import driven, smoothed
from pyident.simulation.replica import Repeat

TIME = np.arange(2000) * 0.004


def test_a_robot_is_driven_by_its_controller():
    assert driven(one_joint())
    assert not driven(replace(one_joint(), controller=None))


def test_inputs_keep_what_is_slow_without_delay_and_lose_what_is_fast():
    """3 Hz passes as it is; 90 Hz of a Nyquist frequency of 125 does not."""
    slow, fast = np.sin(2 * np.pi * 3 * TIME), np.sin(2 * np.pi * 90 * TIME)
    column = (slow + fast)[:, None]
    plan = Experiment(TIME, column, 2 * column)
    again = smoothed(Repeat(Log(pd.DataFrame({"time": TIME})), plan))
    inside = slice(200, -200)
    np.testing.assert_allclose(again.plan.reference[inside, 0], slow[inside], atol=1e-3)
    np.testing.assert_allclose(again.plan.feedforward[inside, 0], 2 * slow[inside], atol=2e-3)
    np.testing.assert_array_equal(again.plan.time, TIME)
