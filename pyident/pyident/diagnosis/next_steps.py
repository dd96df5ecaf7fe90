"""What a verdict leads to: experiments that separate rivals or show a law, leads on the unexplained."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from flexmodels.coordinate import joint_number
from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot, RobotError
from pyident.diagnosis.base.candidates import Candidate, with_law
from pyident.diagnosis.base.setting import set_up, steadied, workers_of
from pyident.diagnosis.motions.revealing import revealing
from pyident.diagnosis.motions.separating import separating
from pyident.diagnosis.result import Diagnosis, Finding, Named, Place
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.unexplained.formula import Draft, symbolic_law
from pyident.diagnosis.unexplained.unexplained import depends_on, side_of
from pyident.excitation.variants import variants
from pyident.logs.log import LogError
from pyident.regression.descriptions import corrected
from pyident.simulation.simulator import OpenPool, rivals


def candidate_of(search: Search, name: Named) -> Candidate:
    """What a diagnosis has named, as the search knows it."""
    joint = joint_number(name.joint)
    if name.describes:
        return Candidate(name.effect, joint)
    law = search.robot.joints[joint - 1].law(name.effect)
    values = tuple((p.name, name.values[p.name]) for p in law.nonlinear)
    sources = [log.source for log in search.examination.setting.logs]
    return Candidate(name.effect, joint, values, None if name.log is None else sources.index(name.log))


def with_experiments(
    search: Search, found: Diagnosis, open_pool: OpenPool, progress: Callable[[float], None]
) -> Diagnosis:
    """Every tie with the motion that separates its first two rivals best, found by simulating both."""
    findings = list(found.findings)
    for i, finding in enumerate(findings):
        if len(finding.tie) < 2 or any(n.describes for n in finding.tie[:2]):
            continue
        others = [f.tie[0] for f in findings if f is not finding]
        offer = f"{finding.experiment}; {_designed(finding)}"
        try:
            sentence = _separating(search, finding, others, open_pool, progress)
        except (RobotError, LogError, SimulationError):
            sentence = ""  # no experiment to vary, or a rival that cannot run: the laws' own words stay
        findings[i] = replace(finding, experiment=f"{sentence}; {offer}" if sentence else offer)
    return replace(found, findings=tuple(findings))


def with_revealing(
    search: Search, found: Diagnosis, open_pool: OpenPool, progress: Callable[[float], None]
) -> Diagnosis:
    """Every law that these logs cannot show with the motion that would, found by simulating the model."""
    if not any(limit.reason for limit in found.limits):
        return found
    try:
        with open_pool(search.examination.setting.simulated) as workers:
            return replace(found, limits=tuple(revealing(search, found.limits, workers, progress)))
    except (RobotError, LogError):
        return found  # no experiment to vary: the laws' own words stay


def _designed(finding: Finding) -> str:
    """How to get the motion that separates a tie as a file."""
    rivals = [named.suspect for named in finding.tie[:2]]
    return f"`pyident excite MODEL --separate {' '.join(rivals)} -o plan.parquet` designs a motion for it"


def _separating(
    search: Search,
    finding: Finding,
    others: Sequence[Named],
    open_pool: OpenPool,
    progress: Callable[[float], None],
) -> str:
    setting = search.examination.setting
    robots = [_having(search, [*others, n]) for n in finding.tie[:2]]
    plans = variants(robots[0], setting.logs[0])
    with rivals(open_pool, robots) as simulate:
        return separating(robots, plans, simulate, setting.noise, progress).sentence


def _having(search: Search, chosen: Sequence[Named]) -> Robot:
    """The robot with effects and corrections, everything fitted to the logs."""
    setting = search.examination.setting
    robot = setting.simulated
    for n in chosen:
        if n.describes:
            robot = corrected(robot, joint_number(n.joint), n.effect, n.values["correction"])
        else:
            robot = with_law(robot, candidate_of(search, n))
    return steadied(set_up(robot, setting.logs)).simulated


def with_dependences(search: Search, found: Diagnosis, open_pool: OpenPool, draft: bool) -> Diagnosis:
    """An unexplained residual with the signals that it depends on; draft: and a formula for it."""
    examination = search.examination
    with workers_of(examination.setting, open_pool) as workers:
        open_rows = [row for row, place in enumerate(found.places) if place.state == "unexplained"]
        leads = depends_on(examination, workers, search.base, open_rows or None)
    told = (*found.depends_on, *leads.sentences, *_not_looked_at(search.robot, found.places, leads.rows))
    if not draft or not leads.dependences:
        return replace(found, depends_on=told)
    proposal = symbolic_law(examination, leads.dependences)
    if not isinstance(proposal, Draft):
        return replace(found, depends_on=(*told, proposal))
    said = f"a draft: {proposal.formula} takes {proposal.share_percent:.0f} % of it"
    said = f"{said}; {proposal.note}" if proposal.note else said
    return replace(found, depends_on=(*told, said), draft=proposal.text)


def _not_looked_at(robot: Robot, places: Sequence[Place], rows: Sequence[int]) -> list[str]:
    """Of equations that are left unexplained, too, but by less. places: in the order of the equations.

    rows   that were looked at
    """
    left = [row for row, place in enumerate(places) if place.state == "unexplained" and row not in rows]
    listed = " and ".join(side_of(robot, row) for row in left)
    why = "less exceeds the floor there" if rows else "they exceed their floors in some frequencies only"
    return [f"{listed}: not looked at further, as {why}"] if left else []
