"""Which physical effect a model lacks, judged by its logs: a name, several names, none we know, or nothing.

The model is fitted; replicas of it show what the method itself leaves. What the data leave beyond that is put
to every effect of the catalogue at every joint. An effect is named only if nothing in the replicas comes near its
gain, if the gain matters, if it holds on logs that were not used, and if, all named together, most of what
exceeds the floor is gone. Else the verdict is `unexplained` or `nothing_detectable`.
"""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import Any

import numpy as np

from flexmodels.robot import Robot
from pyident.candidates import Candidate, bounds, columns
from pyident.detectable import limits, rows_over_floor
from pyident.diagnosis import Diagnosis, Finding, Named, VerdictName
from pyident.evidence import gain, joined, taken_over
from pyident.examination import REPLICAS, Examination, examine, set_up, unbiased, whitened
from pyident.log import Log
from pyident.search import ALPHA, MATERIAL, Found, Search, Step
from pyident.spectra import Equations

OpenWorkers = Callable[[Robot], AbstractContextManager[Any]]
Progress = Callable[[float], None]

RELATIVE = 0.04  # of all that exceeds the floor: a later finding below it is a flaw of an earlier one's law
EXPLAINED = (0.6, 0.7, 0.8, 0.9)  # of what exceeds the floor, by one, two ... effects: below, they do not explain it
MOST = 4  # effects at once


def diagnose(
    robot: Robot,
    logs: Sequence[Log],
    open_workers: OpenWorkers,
    heldout: Sequence[Log] = (),
    progress: Progress = lambda _: None,
    replicas: int = REPLICAS,
) -> Diagnosis:
    """What `robot` lacks in `logs`; its own dynamic parameters are never used.

    open_workers   gives processes that hold a robot's FMU (pyident.pipeline.FmuRuns)
    heldout        logs on which the findings must hold
    Raises LogError.
    """
    search = searched(robot, logs, open_workers, lambda share: progress(0.9 * share), replicas)
    diagnosis = concluded(search, heldout)
    progress(1.0)
    return diagnosis


def searched(
    robot: Robot,
    logs: Sequence[Log],
    open_workers: OpenWorkers,
    progress: Progress = lambda _: None,
    replicas: int = REPLICAS,
) -> Search:
    """The fitted robot's residual in `logs`, its replicas' and every candidate. Raises LogError."""
    setting = set_up(robot, logs)
    progress(0.05)
    with open_workers(setting.simulated) as workers:
        setting = unbiased(setting, workers)
        progress(0.1)
        return Search(examine(setting, workers, lambda share: progress(0.1 + 0.9 * share), replicas))


def concluded(search: Search, heldout: Sequence[Log] = ()) -> Diagnosis:
    """What a search comes to. heldout: logs on which the findings must hold. Raises LogError."""
    setting = search.examination.setting
    accepted, first = _accepted(search)
    held = whitened_heldout(search, heldout)
    judged = [(step, _finding(search, accepted, i, held)) for i, step in enumerate(accepted)]
    kept = [(step, f) for step, f in judged if f.heldout_gain_percent is None or f.heldout_gain_percent > 0]
    return _outcome(setting.robot, setting.logs, heldout, search, first, kept)


def whitened_heldout(search: Search, heldout: Sequence[Log]) -> list[Equations]:
    """The equations of logs that were not used, over the floor of those that were. Raises LogError."""
    ex = search.examination
    return [e for log in heldout for e in whitened(ex.setting.robot, [log], ex.floor)]


def heldout_gain(search: Search, chosen: Sequence[Candidate], held: Sequence[Equations]) -> float:
    """Share of the residual's energy in held-out logs that falls with these candidates fitted to the others."""
    return 1 - _left(search, chosen, held) / _left(search, (), held)


def _accepted(search: Search) -> tuple[list[Step], Step]:
    """The steps of the search that count, each judged with all others in the base; and the first ranking."""
    first = step = search.step()
    chosen: list[Candidate] = []
    while len(chosen) < MOST and _counts(search, step):
        chosen.append(step.tie[0].candidate)
        search.rest_on(chosen)
        step = search.step()
    steps: list[Step] = []
    for candidate in list(chosen):
        search.rest_on([c for c in chosen if c is not candidate])
        step = search.step()
        if _counts(search, step):
            steps.append(step)
            chosen[chosen.index(candidate)] = step.tie[0].candidate
        else:
            chosen.remove(candidate)
    search.rest_on(chosen)
    return steps, first


def _counts(search: Search, step: Step) -> bool:
    needed = max(MATERIAL * search.floor_energy, RELATIVE * search.excess)
    return step.p_value <= ALPHA and step.tie[0].excess >= needed


def _finding(search: Search, steps: Sequence[Step], number: int, held: Sequence[Equations]) -> Finding:
    step = steps[number]
    best = step.tie[0]
    others = [s.tie[0].candidate for i, s in enumerate(steps) if i != number]
    with_it, without = _left(search, [*others, best.candidate], held), _left(search, others, held)
    return Finding(
        tie=tuple(named(search, f) for f in step.tie),
        p_value=step.p_value,
        excess_gain_percent=100 * best.excess / search.examination.base.energy,
        share_percent=100 * best.excess / max(search.excess, best.excess),
        heldout_gain_percent=100 * (1 - with_it / without) if held else None,
        experiment=_experiment(search.robot, step) if len(step.tie) > 1 else "",
    )


def _left(search: Search, chosen: Sequence[Candidate], held: Sequence[Equations]) -> float:
    """Energy of the residual on held-out logs, with everything fitted to the others."""
    robot, base = search.robot, search.examination.base
    p, x, acting = base.p, np.zeros(0), list(chosen)
    if acting:
        X = joined([search.columns(c) for c in acting])
        limits = [bounds(robot, c) for c in acting]
        low, high = (np.concatenate(ends) for ends in zip(*limits, strict=True))
        x = gain(base, X, low, high).coefficients
        p = p - taken_over(base, X) @ x
    return sum(_left_of(search, log, p, x, acting) for log in held)


def _left_of(search: Search, log: Equations, p: np.ndarray, x: np.ndarray, acting: Sequence[Candidate]) -> float:
    """Of one log; a payload is there or not, whichever fits."""
    residual = log.y - log.A @ p
    at = 0
    for candidate in acting:
        everywhere = Candidate(candidate.effect, candidate.joint, candidate.values)
        X = columns(search.robot, everywhere, [log], [np.ones_like(log.y)])[0]
        width = next(iter(X.values())).shape[1]
        level = search.examination.floor.at(log.band)
        more = residual.copy()
        for c, values in X.items():
            more[c] -= values @ x[at : at + width] / level[c]
        if candidate.log is None or np.square(more).sum() < np.square(residual).sum():
            residual = more
        at += width
    return float(np.square(residual).sum())


def named(search: Search, found: Found) -> Named:
    """A candidate as it is reported."""
    robot, c = search.robot, found.candidate
    law = robot.with_effect(c.joint, c.effect).joints[c.joint - 1].law(c.effect)
    linear = [p.name for p in law.linear]
    units = robot.with_effect(c.joint, c.effect).units
    prefix = f"joint{c.joint}.{c.effect}."
    return Named(
        effect=c.effect,
        joint=f"joint{c.joint}",
        values=dict(zip(linear, found.gain.coefficients.tolist(), strict=True)) | dict(c.values),
        std=dict(zip(linear, found.gain.std.tolist(), strict=True)) | {name: np.inf for name, _ in c.values},
        units={p.name: units[prefix + p.name] for p in law.parameters},
        gain_percent=100 * found.excess / max(search.excess, found.excess),
        log=None if c.log is None else search.examination.setting.logs[c.log].source,
    )


def _experiment(robot: Robot, step: Step) -> str:
    """What the rivals' own laws ask for."""
    laws = [(f.candidate, robot.joints[f.candidate.joint - 1].law(f.candidate.effect)) for f in step.tie[:2]]
    return "; ".join(f"for {law.name} at joint {c.joint}: {law.experiment}" for c, law in laws)


def _outcome(
    robot: Robot,
    logs: Sequence[Log],
    heldout: Sequence[Log],
    search: Search,
    first: Step,
    kept: Sequence[tuple[Step, Finding]],
) -> Diagnosis:
    ex = search.examination
    steps, findings = [step for step, _ in kept], [finding for _, finding in kept]
    explained = _explained(search, [step.tie[0].candidate for step in steps])
    rows = rows_over_floor(ex)
    verdict = _verdict(search, findings, explained)
    worst = max(rows, key=lambda row: max(row.over_floor))
    localised = _place(findings, search.robot, steps) or (worst.joint, worst.balance)
    return Diagnosis(
        robot=robot.name,
        logs=tuple(log.source for log in logs),
        heldout=tuple(log.source for log in heldout),
        verdict=verdict,
        sentence=_sentence(verdict, findings, explained, localised),
        findings=tuple(findings),
        localised=None if verdict == "nothing_detectable" else localised,
        limits=tuple(limits(search)),
        rows=tuple(rows),
        excess=1 + search.excess / search.floor_energy,
        remaining=1 + search.remaining / search.floor_energy,
        ranking=tuple(named(search, f) for f in (*first.tie, *first.others)),
        noise=ex.setting.noise,
    )


def _verdict(search: Search, findings: Sequence[Finding], explained: Sequence[float]) -> VerdictName:
    if any(share >= needed for share, needed in zip(explained, EXPLAINED, strict=False)):
        return "missing_effect" if len(findings[0].tie) == 1 else "cannot_tell"
    return "unexplained" if findings or search.stands_out else "nothing_detectable"


def _explained(search: Search, chosen: Sequence[Candidate]) -> list[float]:
    """Share of the excess that the first finding takes away, the first two ..."""
    shares = []
    for n in range(1, len(chosen) + 1):
        search.rest_on(chosen[:n])
        shares.append(search.explained)
    return shares


def _place(findings: Sequence[Finding], robot: Robot, steps: Sequence[Step]) -> tuple[str, str] | None:
    if not findings:
        return None
    c = steps[0].tie[0].candidate
    law = robot.with_effect(c.joint, c.effect).joints[c.joint - 1].law(c.effect)
    acts = {str(q) for q in law.forces}
    balance = "motor" if "e" in acts else "transmission" if "eps1" in acts else "link"
    return f"joint{c.joint}", balance


def _sentence(
    verdict: VerdictName, findings: Sequence[Finding], shares: Sequence[float], place: tuple[str, str]
) -> str:
    explained = shares[-1] if shares else 0.0
    names = " and ".join(
        " or ".join(f"{n.effect} at {n.joint}" for n in f.tie) for f in findings
    )
    if verdict == "nothing_detectable":
        return "Nothing is missing that these logs could show."
    where = f"{place[0]}, {place[1]} side"
    if verdict == "unexplained":
        so_far = f" {names} takes {100 * explained:.0f} % of it." if findings else ""
        return f"Something is missing at {where}, but no effect of the catalogue explains it.{so_far}"
    if verdict == "cannot_tell":
        return f"{names}: these logs cannot tell which; {100 * explained:.0f} % of the excess is explained."
    return f"{names} is missing: it explains {100 * explained:.0f} % of what exceeds the floor."
