"""Which motion shows a law that the logs could not. The answer is tried: recorded, and diagnosed again."""

import re

import numpy as np
import pytest
from one_joint import PERIOD, one_joint
from two_link_logs import in_process, loaded

from flexmodels.experiment import Experiment
from flexmodels.robot import Robot
from flexmodels.settings.motions import Identification, Multisine
from pyident.diagnosis.motions.detectable import limits
from pyident.diagnosis.motions.revealing import revealing
from pyident.diagnosis.result import Limit
from pyident.diagnosis.searched import searched
from pyident.excitation.variants import variants
from pyident.logs.log import Log
from pyident.rules.replicas import ReplicaRules
from pyident.rules.rules import Rules
from pyident.rules.search import SearchRules
from pyident.simulation.replica import Repeat

LAW = "asymmetric_coulomb"
NOISE = {"joint1.e": 2e-6}
FEW = Rules(replicas=ReplicaRules(count=6), search=SearchRules(level=0.15))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("revealing")


def arm() -> Robot:
    plan = Identification((1.0,), 2.0, 16.0, Multisine((1.0,), 40, 0.5, 30.0))
    return one_joint().with_settings(identification=plan)


def one_way() -> Experiment:
    """Faster and slower, never back: friction that depends on the direction is friction."""
    time = np.arange(0, 12, PERIOD)
    reference = 0.5 * time + 0.2 * (1 - np.cos(2 * time)) * np.minimum(time, 1.0)
    return Experiment(time, reference[:, None], np.zeros((len(time), 1)))


def recorded(robot: Robot, plan: Experiment, folder, seed: int) -> Log:
    with loaded(robot, folder) as fmu:
        first = Log(fmu.simulate(plan), f"log {seed}")
        return Repeat(first, plan).replica(fmu.simulate, robot.parameters, NOISE, seed)


def shown(known: Robot, log: Log, folder) -> Limit:
    search = searched(known, [log], in_process, rules=FEW)
    with in_process(search.examination.setting.simulated) as workers:
        found = revealing(search, list(limits(search)), workers)
    return next(x for x in found if x.effect == LAW)


def seen(logs: list[Log], folder) -> bool:
    search = searched(arm(), logs, in_process)
    best = search.best(LAW, 1)
    return best is not None and search.p_value(best) <= search.rules.level


def test_a_law_is_seen_after_the_motion_that_is_asked_for(folder):
    limit = shown(arm(), recorded(arm(), one_way(), folder, 0), folder)
    assert limit.reason == "the model's own parameters imitate it in these logs"
    asked = re.fullmatch(r"run (.+): there coulomb from about (\S+) N\.m would be seen", limit.experiment)
    assert asked is not None, limit.experiment
    plan, least = variants(arm(), duration=12.0)[asked[1]], float(asked[2])
    hidden = arm().with_effect(1, LAW).with_parameters({f"joint1.{LAW}.coulomb": 3 * least})
    as_before, as_asked = (recorded(hidden, p, folder, i) for i, p in enumerate((one_way(), plan)))
    assert not seen([as_before], folder)
    assert seen([as_before, as_asked], folder)


def test_no_motion_in_one_direction_would_show_it(folder):
    limit = shown(one_joint_without_plan(), recorded(arm(), one_way(), folder, 0), folder)
    assert limit.experiment.startswith("none of the motions tried would show it; it takes ")


def one_joint_without_plan() -> Robot:
    return one_joint().with_settings(identification=None)
