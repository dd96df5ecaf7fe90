"""What a damping does to a simulation's own residual: the column predicts simulations nobody differenced."""

from dataclasses import replace

import numpy as np
import pytest
from two_link_logs import in_process, loaded, two_link

from flexmodels.experiment import Experiment
from pyident.conditioning.weak_form import condition
from pyident.estimation.instrumental_variables import Rows
from pyident.logs.log import Log
from pyident.refinement.instruments.simulated_columns import simulated_columns
from pyident.refinement.instruments.simulated_rows import Repeated, in_memory, rows_of, simulations
from pyident.regression.equations import Problem
from pyident.simulation.replica import repeats


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Log:
    robot, time = two_link(), np.arange(700) / 250
    swing = np.column_stack([0.6 * (1 - np.cos(2 * np.pi * time / period)) for period in (2.7, 2.2)])
    plan = Experiment(time, swing, np.column_stack([4 * np.cos(40 * time), 1.5 * np.cos(63 * time)]))
    with loaded(robot, tmp_path_factory.mktemp("columns")) as fmu:
        return Log(fmu.simulate(plan), "log")


def test_a_column_is_the_change_that_another_damping_makes(log):
    robot = two_link()
    data = in_memory(robot, condition(log, robot))
    followed, again = repeats(robot, [log])
    logs = Repeated(robot, [data], again, Problem(robot, (data.part,)).reduced())
    names = list(robot.linear_parameters)

    def residual(workers, put_in) -> tuple[np.ndarray, np.ndarray, Rows]:
        p = np.array([put_in[n] for n in names])
        rows = rows_of(robot, data, simulations(again, workers, put_in)[1][0], p)
        return data.y - rows.y, p, rows

    with in_process(followed) as workers:
        base, p, rows = residual(workers, robot.parameters)
        columns = simulated_columns(logs, [rows], workers, robot.parameters)
        place = names.index("joint1.d[1]")
        assert set(columns.slopes[0]) == {j for j, name in enumerate(names) if ".d[" in name}
        smaller = robot.parameters | {names[place]: 0.9 * robot.parameters[names[place]]}
        there, q, _ = residual(workers, smaller)
    predicted = columns.slopes[0][place] * (q - p)[place]
    used = data.use > 0
    left = np.linalg.norm((there - base - predicted)[used]) / np.linalg.norm((there - base)[used])
    assert np.abs(there - base)[used].max() > 0
    assert left < 0.25
    added = columns.added(0, rows, p)
    np.testing.assert_allclose(added.y - added.A @ p, rows.y - rows.A @ p, atol=1e-9)
    np.testing.assert_array_equal(added.Z, rows.Z)


def test_without_a_loop_nothing_is_added(log):
    """Nothing of a stand-in's equations is in the targets."""
    robot = replace(two_link(), controller=None)
    data = in_memory(robot, condition(log, robot))
    logs = Repeated(robot, [data], repeats(robot, [log])[1], Problem(robot, (data.part,)).reduced())
    with in_process(robot) as workers:
        columns = simulated_columns(logs, [], workers, robot.parameters)
    assert not any(columns.slopes)
