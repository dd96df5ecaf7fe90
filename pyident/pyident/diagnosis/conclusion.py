"""What a search comes to: findings with their numbers, every place's state, a verdict."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.coordinate import joint_name
from pyident.diagnosis.another_state import other_states, sentence
from pyident.diagnosis.base.candidates import Candidate, law_of, units_of
from pyident.diagnosis.base.floor_shares import floor_shares
from pyident.diagnosis.base.residual_over_floor import EDGES, Region
from pyident.diagnosis.base.standing_out import bands_in_doubt, bands_standing_out, in_bands
from pyident.diagnosis.coefficients import gain_beside, loosely_told
from pyident.diagnosis.late_torque import comes_late, time_of
from pyident.diagnosis.motions.detectable import limits, rows_over_floor
from pyident.diagnosis.notes import (
    doubted_joints,
    in_doubt,
    in_motion,
    in_time,
    of_bursts,
    of_drifts,
    of_ends,
    of_gears,
    of_mends,
    of_one_order,
    of_speeds,
    of_springs,
    of_time,
    of_what_is_shared,
    warnings,
)
from pyident.diagnosis.result import Diagnosis, Finding, Named, Place, Stage
from pyident.diagnosis.search.found import Found, Step, candidates_of, others_than
from pyident.diagnosis.search.further_orders import orders_of
from pyident.diagnosis.search.gate import Refusal, nothing_left, region_of, share_in
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.search.selection import Selection
from pyident.diagnosis.unexplained.bursts import in_bursts
from pyident.diagnosis.unexplained.other_torques import follow_other_torques
from pyident.diagnosis.unexplained.slow_floors import of_slow_floors, slow_floors
from pyident.diagnosis.verdict import asked_for, place_of, sentence_of, verdict_of
from pyident.logs.log import Log
from pyident.regression.loads.swinging_drive import from_values


def conclusion(search: Search, selection: Selection, held: HeldOut, heldout: Sequence[Log]) -> Diagnosis:
    """Of a search that rests on nothing. heldout: the logs of `held`."""
    ex, robot = search.examination, search.robot
    beside = search.resting_on(selection.candidates)
    findings = tuple(_finding(search, selection, i, held) for i in range(len(selection.steps)))
    places = tuple(_places(search, beside, selection, held))
    rows = rows_over_floor(ex)
    worst = rows[int(np.argmax(search.over_floor))]
    steps = selection.steps
    localised = place_of(robot, steps[0].best.candidate) if steps else (worst.joint, worst.balance)
    bursts, doubted = in_bursts(beside, places), doubted_joints(beside, places)
    slow = slow_floors(beside, [p for p in places if p.joint not in doubted])
    shaken = [joint_name(robot.q[row].joint) for row in bursts]
    moving = in_motion(search, places)
    noisy = {
        p.joint: p.floor_percent
        for p in moving
        if p.balance == "motor" and p.floor_percent > 100 * search.rules.worthless
    }
    verdict = verdict_of(findings, any(p.state == "unexplained" for p in places))
    stages = tuple(_stages(search, findings, steps))
    shown = {(n.effect, n.joint) for f in findings for n in f.tie}  # though their limit may not be known
    seen = [f.candidate for f in selection.first.ranked if search.p_value(f) <= search.rules.level]
    shown |= {(c.effect, joint_name(c.joint)) for c in seen}
    states = other_states(beside, held, heldout)
    told = () if ex.setting.unfollowed else limits(search, beside, held)
    return Diagnosis(
        robot=robot.name,
        logs=tuple(log.source for log in ex.setting.logs),
        heldout=tuple(log.source for log in heldout),
        verdict=verdict,
        sentence=in_time(ex.setting.alignment)
        + sentence_of(verdict, findings, places, localised, [*doubted, *slow], shaken, noisy)
        + "".join(f" And {note.partition(':')[0]}." for note in selection.notes if not findings)
        + sentence(states),
        findings=findings,
        localised=None if verdict == "nothing_detectable" else localised,
        limits=tuple(x for x in told if not x.reason or (x.effect, x.joint) not in shown),
        rows=tuple(rows),
        excess=stages[0].over_floor,
        remaining=stages[-1].over_floor,
        ranking=tuple(_beside(search, beside, f) for f in selection.first.ranked),
        depends_on=tuple(
            f"{name} fits in part, but {why}: it only imitates"
            for name, why in selection.imitators.items()
            if name not in {f"{n.effect} at {n.joint}" for f in findings for n in f.tie}
        ),
        notes=(
            *filter(None, [ex.setting.unfollowed]),
            *of_time(ex.setting),
            *(state.note for state in states),
            *(orders_of(search.robot, step) for step in steps if step.orders),
            *of_one_order(search, selection, held),
            *of_speeds(search, selection),
            *warnings(search, verdict, moving),
            *of_what_is_shared(places, findings),
            *of_drifts(findings),
            *of_bursts(beside, bursts),
            *of_slow_floors(slow),
            *in_doubt(beside, places, selection.refusals),
            *of_gears(findings),
            *of_ends(search.robot, findings),
            *of_springs(findings),
            *of_mends(findings),
            *selection.notes,
        ),
        noise=ex.setting.noise,
        stages=stages,
        places=places,
        band=float(ex.floor.frequencies[-1]),
        put_in_time=ex.setting.alignment.needed,
    )


def _finding(search: Search, selection: Selection, number: int, held: HeldOut) -> Finding:
    step = selection.steps[number]
    view = search.resting_on(others_than(step, selection.steps))
    region = region_of(view, step.best.candidate)
    unseen = held.share(view, step.candidates, region)
    beside, alike = [*view.chosen, *step.orders], _alike(view, step)
    return Finding(
        tie=tuple(_together(search, f, beside, held) for f in step.tie),
        p_value=step.p_value,
        excess_gain_percent=100 * step.best.excess / search.examination.base.energy,
        share_percent=100 * _share_of_excess(view, step.candidates, region),
        heldout_gain_percent=None if unseen is None else 100 * unseen.share,
        heldout_std_percent=None if unseen is None else 100 * unseen.std,
        experiment="" if alike else asked_for(search.robot, [f.candidate for f in step.tie]),
        alike=alike,
        replicas=len(search.families.peaks),
    )


def _alike(view: Search, step: Step) -> bool:
    """Whether all of a tie are errors of the robot file that one correction mends, whatever the motion."""
    best, *others = (f.candidate for f in step.tie)
    if not others or not all(f.candidate.describes for f in step.tie):
        return False
    beside = view.with_further([best])
    return all(beside.imitates(c) for c in others)


def _share_of_excess(view: Search, candidates: Sequence[Candidate], region: Region) -> float:
    """What a finding takes of what exceeds the floor; of so little that none would be named for it: 0."""
    if nothing_left(view, region):
        return 0.0
    return max(share_in(view, candidates, region), 0.0)


def _together(search: Search, found: Found, others: Sequence[Candidate], held: HeldOut) -> Named:
    """A candidate as it is reported, with the coefficients that it has beside others.

    An error of the robot file is small beside the noise, so that its value is that of all logs. Of a drive on
    which a link swings it is its spring's, as what noise lessens is the size of the swing.
    """
    if found.candidate.describes:
        spring = from_values(found.candidate.values).get(found.candidate.joint)
        if spring is not None and spring.swings:
            told = np.array([spring.compliance])
            return named(search, replace(found, gain=replace(found.gain, coefficients=told)))
        beside = search.resting_on(others)
        value = held.together(beside, found.candidate)
        if comes_late(search.robot, found.candidate):
            value = np.array([time_of(beside, found.candidate.joint, float(value[0]))])
        return named(search, replace(found, gain=replace(found.gain, coefficients=value)))
    own = gain_beside(search, others, found.candidate)
    loose, K = loosely_told(search, others, found.candidate), len(own.std)
    std = np.where(loose[:K], np.inf, own.std)
    said = named(search, replace(found, gain=replace(found.gain, coefficients=own.coefficients, std=std)))
    told = tuple(n for n, unknown in zip(said.nonlinear, loose[K:].tolist(), strict=True) if not unknown)
    return replace(said, nonlinear=told)


def named(search: Search, found: Found) -> Named:
    """A candidate as it is reported."""
    robot, c = search.robot, found.candidate
    law = law_of(robot, c)
    linear = [p.name for p in law.linear]
    x, std = _at_its_speed(search, found)
    std = np.full(len(linear), np.inf) if c.describes else std  # see `wrong_description`
    return Named(
        effect=c.effect,
        joint=joint_name(c.joint),
        values=dict(zip(linear, x.tolist(), strict=True)) | dict(c.nonlinear),
        std=dict(zip(linear, std.tolist(), strict=True)) | {name: np.inf for name, _ in c.nonlinear},
        units=units_of(robot, c),
        gain_percent=percent(found.excess, search),
        log=None if c.log is None else search.examination.setting.logs[c.log].source,
        nonlinear=tuple(linear) if c.describes else tuple(name for name, _ in c.nonlinear),
    )


def _at_its_speed(search: Search, found: Found) -> tuple[np.ndarray, np.ndarray]:
    """The coefficients of a law and their standard deviations; of one that has them at every speed, those at
    the speed nearest to the mean of its joint's.
    """
    c, gain = found.candidate, found.gain
    if not c.speeds:
        return gain.coefficients, gain.std
    speed = np.concatenate([log.part.motion.dq[:, c.joint - 1] for log in search.examination.logs])
    nearest = int(np.argmin(np.abs(np.array(c.speeds) - np.abs(speed).mean())))
    at = slice(nearest, None, len(c.speeds))
    return gain.coefficients[at], gain.std[at]


def percent(energy: float, search: Search) -> float:
    """Of what exceeds the floor, in all or band by band. The search rests on nothing."""
    return 100 * energy / max(search.excess, search.lacking.sum(), energy, 1e-300)


def _places(search: Search, beside: Search, selection: Selection, held: HeldOut) -> Iterator[Place]:
    robot = search.robot
    before, after = search.over_floor, beside.over_floor
    floor = (100 * floor_shares(search.examination)).tolist()
    acting = {row for c in selection.candidates for row in search.rows(c)}
    used = search.examination.used
    out, above = beside.standing_out, bands_standing_out(search.examination, beside.base)
    doubted = bands_in_doubt(search.examination, beside.base)
    rows = [row for row in range(len(robot.joints)) if doubted[row].any() and not above[row].any()]
    following = follow_other_torques(beside, held, rows)
    for row, coordinate in enumerate(robot.q):
        refusal = next((r for r in selection.refusals if row in r.region.rows), None)
        bands = above[row]
        if row in following or (refusal is not None and refusal.certain):
            bands = bands | doubted[row]
        left = bool(out[row] or bands.any())
        calm = "in_order" if used[row] else "unobserved"
        state = "unexplained" if left else "explained" if row in acting else calm
        ratio = (float(np.sqrt(before[row])), float(np.sqrt(after[row])))
        reason = _said(refusal) if refusal and left else ""
        joint = joint_name(coordinate.joint)
        yield Place(joint, coordinate.side, state, ratio, floor[row], reason, _worst_band(beside, row, bands))


def _worst_band(beside: Search, row: int, out: np.ndarray) -> tuple[float, float, float] | None:
    """The worst of the bands `out` where an equation stands out, if it does so more than in all together."""
    ex = beside.examination
    ratio = np.where(out, in_bands(ex, beside.base).ratio[row], 0.0)
    band, top = int(np.argmax(ratio)), float(ex.floor.frequencies[-1])
    if ratio[band] <= beside.over_floor[row]:
        return None
    ends = (*EDGES, np.inf)
    return ends[band], min(ends[band + 1], top), float(np.sqrt(ratio[band]))


def _said(refusal: Refusal) -> str:
    c = refusal.candidate
    return f"{c.effect} at joint{c.joint} comes nearest, but {refusal.reason}"


def _beside(search: Search, beside: Search, found: Found) -> Named:
    """A candidate by itself, and what it would still take away beside those that the search rests on."""
    excess = max(beside.gain_of(found.candidate).energy - found.pretended, 0.0)
    return replace(named(search, found), beside_percent=percent(excess, search))


def _stages(search: Search, findings: Sequence[Finding], steps: Sequence[Step]) -> Iterator[Stage]:
    """One finding after the other."""
    for n in range(len(steps) + 1):
        view = search.resting_on(candidates_of(steps[:n]))
        added = findings[n - 1].tie[0] if n else None
        yield Stage(added, float(np.mean(view.over_floor)))
