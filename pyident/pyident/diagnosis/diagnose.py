"""Which physical effect a model lacks, judged by its logs: a name, several names, none we know, or nothing.

The model is fitted; replicas of it show what the method itself leaves. What the data leave beyond that is put
to every effect of the catalogue at every joint. An effect is named only if nothing in the replicas comes near
its gain, if the gain matters, if it holds on logs that were not used, and if, all named together, most of
what exceeds the floor is gone. Else the verdict is `unexplained` or `nothing_detectable`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.inputs import SimulationError
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.checks.check_log import check_log
from pyident.diagnosis.base.candidates import law_of
from pyident.diagnosis.base.residual_over_floor import REPLICAS, Setting, examine, set_up, steadied, unbiased
from pyident.diagnosis.motions.detectable import limits, rows_over_floor
from pyident.diagnosis.next_steps import OpenRivals, with_dependences, with_experiments, with_revealing
from pyident.diagnosis.result import Diagnosis, Finding, Named, Stage
from pyident.diagnosis.search.held_out import left_over, whitened_heldout
from pyident.diagnosis.search.search import Found, Search, Step
from pyident.diagnosis.search.selection import MATERIAL, Selection, select
from pyident.diagnosis.search.trace_in_simulation import Trace, law_values, traces
from pyident.diagnosis.verdict import asked_for, place_of, sentence_of, verdict_of
from pyident.logs.log import Log, LogError
from pyident.regression.spectrum import Equations
from pyident.simulation.replica import OpenWorkers

Progress = Callable[[float], None]


def diagnose(
    robot: Robot,
    logs: Sequence[Log],
    open_workers: OpenWorkers,
    open_rivals: OpenRivals,
    heldout: Sequence[Log] = (),
    progress: Progress = lambda _: None,
    draft: bool = False,
) -> Diagnosis:
    """What `robot` lacks in `logs`; its own dynamic parameters are never used.

    open_workers   gives processes that hold a robot's FMU (pyident.simulation.fmu_runs.FmuRuns)
    open_rivals    gives simulations of several robots at once (pyident.simulation.fmu_runs.RivalRuns)
    heldout        logs on which the findings must hold
    draft          look for a formula where no law explains the residual
    Raises LogError.
    """
    notes = tuple(defect.sentence for log in (*logs, *heldout) for defect in check_log(robot, log))
    search = searched(robot, logs, open_workers, lambda share: progress(0.8 * share))
    found = concluded(search, open_workers, heldout)
    if found.verdict == "unexplained":
        found = with_dependences(search, found, open_workers, draft)
    found = with_experiments(search, found, open_rivals, lambda share: progress(0.85 + 0.1 * share))
    found = with_revealing(search, found, open_workers, lambda share: progress(0.95 + 0.05 * share))
    progress(1.0)
    return replace(found, notes=(*notes, *found.notes))


def searched(
    robot: Robot,
    logs: Sequence[Log],
    open_workers: OpenWorkers,
    progress: Progress = lambda _: None,
    replicas: int = REPLICAS,
) -> Search:
    """The fitted robot's residual in `logs`, its replicas' and every candidate. Raises LogError.

    A fit that cannot be simulated is damped until it can; the regression's bias then stays.
    """
    setting = set_up(robot, logs)
    progress(0.05)

    def examined(start: Setting, adjust: Callable[[Setting, Any], Setting]) -> Search:
        with open_workers(start.simulated) as workers:
            found = adjust(start, workers)
            progress(0.2)
            return Search(examine(found, workers, lambda share: progress(0.2 + 0.8 * share), replicas))

    try:
        return examined(setting, unbiased)
    except SimulationError:
        pass
    try:
        return examined(steadied(setting), lambda start, _: start)
    except SimulationError as error:
        raise LogError(
            f"{logs[0].source}: the fit of robot {robot.name} to it cannot be simulated ({error}); check the "
            "units and signs of its columns, and that the robot file has the right joints"
        ) from None


def concluded(search: Search, open_workers: OpenWorkers, heldout: Sequence[Log] = ()) -> Diagnosis:
    """What a search comes to. heldout: logs on which the findings must hold. Raises LogError.

    Where no law evaluated along the logs explains them, the laws are judged by their signatures.
    """
    selection = select(search)
    held = whitened_heldout(search, heldout)
    judged = [(step, _finding(search, selection, i, held)) for i, step in enumerate(selection.steps)]
    kept = [(step, f) for step, f in judged if f.heldout_gain_percent is None or f.heldout_gain_percent > 0]
    found = _outcome(search, selection, heldout, kept)
    if found.verdict != "unexplained":
        return found
    return _by_signature(search, found, traces(search, heldout, open_workers))


def _by_signature(search: Search, found: Diagnosis, shown: Sequence[Trace]) -> Diagnosis:
    """The diagnosis with what signatures show, if they do."""
    if not shown:
        return found
    share, held = shown[0].explained, shown[0].heldout
    finding = Finding(
        tie=tuple(_traced(search, trace) for trace in shown),
        p_value=1 / (1 + len(search.peaks)),
        excess_gain_percent=100 * share * search.excess / search.examination.base.energy,
        share_percent=100 * share,
        heldout_gain_percent=None if held is None else 100 * held,
        experiment=asked_for(search.robot, [trace.candidate for trace in shown]),
    )
    verdict, place = verdict_of([finding], True), place_of(search.robot, shown[0].candidate)
    left = 1 + (1 - share) * search.excess / search.floor_energy
    return replace(
        found,
        verdict=verdict,
        sentence=sentence_of(verdict, [finding], share, place),
        findings=(finding,),
        localised=place,
        remaining=left,
        stages=(found.stages[0], Stage(finding.tie[0], left)),
        depends_on=(),
        notes=("The finding rests on simulation: along these logs, its joint rings too fast for its law.",),
    )


def _traced(search: Search, trace: Trace) -> Named:
    values, std = law_values(trace)
    c, robot = trace.candidate, trace.setting.robot
    units = {name: robot.units[parameter_name(c.joint, c.effect, name)] for name in values}
    fixed = tuple(name for name, _ in c.values)
    return Named(c.effect, joint_name(c.joint), values, std, units, 100 * trace.explained, nonlinear=fixed)


def _finding(search: Search, selection: Selection, number: int, held: Sequence[Equations]) -> Finding:
    step = selection.steps[number]
    others = [c for i, other in enumerate(selection.steps) if i != number for c in other.candidates]
    with_it, without = left_over(search, selection.candidates, held), left_over(search, others, held)
    return Finding(
        tie=tuple(named(search, f) for f in step.tie),
        p_value=step.p_value,
        excess_gain_percent=100 * step.best.excess / search.examination.base.energy,
        share_percent=_percent(step.best.excess, search),
        heldout_gain_percent=100 * (1 - with_it / without) if held else None,
        experiment=asked_for(search.robot, [f.candidate for f in step.tie]),
    )


def _percent(energy: float, search: Search) -> float:
    """Of what exceeds the floor."""
    return 100 * energy / max(search.excess, energy, 1e-300)


def named(search: Search, found: Found) -> Named:
    """A candidate as it is reported."""
    robot, c = search.robot, found.candidate
    law = law_of(robot, c)
    linear = [p.name for p in law.linear]
    units = robot.with_effect(c.joint, c.effect).units
    return Named(
        effect=c.effect,
        joint=joint_name(c.joint),
        values=dict(zip(linear, found.gain.coefficients.tolist(), strict=True)) | dict(c.values),
        std=dict(zip(linear, found.gain.std.tolist(), strict=True)) | {name: np.inf for name, _ in c.values},
        units={p.name: units[parameter_name(c.joint, c.effect, p.name)] for p in law.parameters},
        gain_percent=_percent(found.excess, search),
        log=None if c.log is None else search.examination.setting.logs[c.log].source,
        nonlinear=tuple(name for name, _ in c.values),
    )


def _outcome(
    search: Search, selection: Selection, heldout: Sequence[Log], kept: Sequence[tuple[Step, Finding]]
) -> Diagnosis:
    ex, robot = search.examination, search.robot
    findings = [finding for _, finding in kept]
    verdict = verdict_of(findings, search.stands_out)
    rows = rows_over_floor(ex)
    worst = max(rows, key=lambda row: max(row.over_floor))
    localised = place_of(robot, kept[0][0].best.candidate) if kept else (worst.joint, worst.balance)
    ranking = tuple(_beside(search, f) for f in selection.first.ranked)
    stages = tuple(_stages(search, kept))
    return Diagnosis(
        robot=robot.name,
        logs=tuple(log.source for log in ex.setting.logs),
        heldout=tuple(log.source for log in heldout),
        verdict=verdict,
        sentence=sentence_of(verdict, findings, search.explained, localised),
        findings=tuple(findings),
        localised=None if verdict == "nothing_detectable" else localised,
        limits=tuple(limits(search, MATERIAL)),
        rows=tuple(rows),
        excess=stages[0].over_floor,
        remaining=stages[-1].over_floor,
        ranking=ranking,
        depends_on=tuple(
            f"{name} fits in part, but {why}: it only imitates" for name, why in selection.imitators.items()
        ),
        notes=tuple(_orders_of(step) for step, _ in kept if step.orders),
        noise=ex.setting.noise,
        stages=stages,
    )


def _orders_of(step: Step) -> str:
    best = step.best.candidate
    more = ", ".join(f"{dict(c.values)['order']:.4g}" for c in step.orders)
    return f"{best.effect} at joint{best.joint} has further orders, counted with it: {more} per turn."


def _beside(search: Search, found: Found) -> Named:
    """A candidate by itself, and what it would still take away beside those that the search rests on."""
    excess = max(search.gain_of(found.candidate).energy - found.pretended, 0.0)
    return replace(named(search, found), beside_percent=_percent(excess, search))


def _stages(search: Search, kept: Sequence[tuple[Step, Finding]]) -> Iterator[Stage]:
    """One finding after the other; leaves the search resting on all."""
    for n in range(len(kept) + 1):
        search.rest_on([c for step, _ in kept[:n] for c in step.candidates])
        added = kept[n - 1][1].tie[0] if n else None
        yield Stage(added, 1 + search.remaining / search.floor_energy)
