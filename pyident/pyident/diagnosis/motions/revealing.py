"""Which motion would show a law that the logs could not, found by simulating variants of an experiment.

The fitted model runs every variant, with the sensors' noise. Along each motion the law is asked again how
large it would have to be, over what the method leaves of these replicas. What the law itself would change in
the motion is left out, and how the search would fare there is taken from the logs at hand.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.experiment import Experiment
from flexmodels.inputs import SimulationError
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import solve_base
from pyident.diagnosis.base.replicas import replicated
from pyident.diagnosis.base.residual_over_floor import gains_of, whitened
from pyident.diagnosis.base.setting import Setting
from pyident.diagnosis.motions.detectable import limit_of, needed_gain
from pyident.diagnosis.result import Limit
from pyident.diagnosis.search.search import Search
from pyident.excitation.variants import variants
from pyident.regression.candidate_columns import nonlinear_grid
from pyident.regression.spectrum import floor
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Simulator, Workers


def revealing(
    search: Search,
    limits: Sequence[Limit],
    workers: Workers,
    progress: Callable[[float], None] = lambda _: None,
) -> list[Limit]:
    """The limits; those with a reason why the law cannot be seen with the motion that would show it best.

    workers   processes that hold the fitted robot's FMU
    Raises RobotError and LogError where there is no experiment to vary.
    """
    hidden = {(x.effect, x.joint) for x in limits if x.reason}
    families = [
        (e, k) for e, k, log, answered in search.families.members if log in (None, 0) and not answered
    ]
    asked = [(e, k) for e, k in families if (e, joint_name(k)) in hidden]
    least = float(np.median([search.needed(family) for family in range(len(search.families.members))]))
    needed = needed_gain(search.rules, least, left=0.0, unseen=0.0, ratio=1.0)  # one of two such logs
    setting = search.examination.setting
    plans = variants(setting.simulated, setting.logs[0])
    jobs = {name: workers.submit(_along, setting, plan, asked, needed) for name, plan in plans.items()}
    shown: dict[tuple[str, str], tuple[float, str]] = {}
    for number, (name, job) in enumerate(jobs.items(), start=1):
        for limit in job.result():
            at = limit.effect, limit.joint
            if not limit.reason and limit.share_percent < shown.get(at, (float("inf"), ""))[0]:
                shown[at] = limit.share_percent, f"run {name}: there {_amplitude(limit)} would be seen"
        progress(number / len(jobs))
    return [replace(x, experiment=_sentence(x, shown)) if x.reason else x for x in limits]


def _along(
    fmu: Simulator, setting: Setting, plan: Experiment, asked: Sequence[tuple[str, int]], needed: float
) -> list[Limit]:
    """Of every law, by its name and joint; none where the model cannot run the motion.

    needed   gain that a law would be named for
    """
    robot = setting.robot
    varied = replace(setting, repeats=(Repeat(setting.logs[0], plan),))
    try:
        made = replicated(fmu, varied, range(setting.rules.replicas.revealing))
    except SimulationError:
        return []
    level = floor([b for _, bands, _ in made for b in bands], [r for *_, left in made for r in left])
    (along,) = whitened(robot, made[0][0], [level])
    base, found = solve_base([along]), []
    for effect, joint in asked:
        grid = nonlinear_grid(robot, joint, effect, [along.part.motion])
        listed = [Candidate(effect, joint, tuple(values.items())) for values in grid]
        gains = gains_of(robot, [along], base, [level], listed)
        best = min(range(len(listed)), key=lambda i: float(gains[i].alone.min()))
        found.append(limit_of(robot, along, listed[best], gains[best], needed, setting.rules.search))
    return found


def _amplitude(limit: Limit) -> str:
    name, value = next(iter(limit.smallest.items()))
    return f"{name} from about {value:.1g} {limit.units[name]}".rstrip()


def _sentence(limit: Limit, shown: Mapping[tuple[str, str], tuple[float, str]]) -> str:
    found = shown.get((limit.effect, limit.joint))
    return found[1] if found else f"none of the motions tried would show it; it takes {limit.experiment}"
