"""What is said beside the findings of a diagnosis: what makes it worth less, and what may be behind it."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from flexmodels.coordinate import joint_name, joint_number
from flexmodels.effects.effect import Parameter
from flexmodels.effects.structure import joint_spring
from flexmodels.robot import Robot
from pyident.conditioning.alignment import HELD, Alignment, OwnWay
from pyident.conditioning.standing import standing_in
from pyident.diagnosis.base.candidates import units_of
from pyident.diagnosis.base.floor_shares import lowered_by
from pyident.diagnosis.base.nonlinear_values import BEYOND
from pyident.diagnosis.base.residual_over_floor import EDGES
from pyident.diagnosis.base.setting import Setting
from pyident.diagnosis.base.standing_out import bands_in_doubt, in_bands
from pyident.diagnosis.result import Finding, Place
from pyident.diagnosis.search.found import others_than
from pyident.diagnosis.search.gate import Refusal, region_of, share_in
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.same_order import same_order
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.search.selection import Selection
from pyident.diagnosis.unexplained.bursts import SLOW, Bursts
from pyident.regression.candidate_columns import counted_along_motion
from pyident.regression.descriptions import outside_file

_MANY, _MOST = 3, 2 / 3  # joints, and of those that move: more are seldom wrong each by itself
_AT_END = 0.01  # of a value's range
_OF_LOAD = ("load_dependent_friction", "quadratic_load_friction")


def in_time(found: Alignment) -> str:
    """What came late, before a verdict; empty: nothing."""
    return f"{apart(found)}. That put right: " if found.needed else ""


def apart(found: Alignment) -> str:
    """What kept positions and torques apart, which something did."""
    parts = ["all torques are held from their sample on, as a loop commands them"] if found.held else []
    if np.isfinite(found.corner):
        parts.append(f"all torques come through a low pass of about {found.corner:.2g} Hz")
    if found.delayed:
        parts.append(f"all positions come about {_late(found.late)} against the torques")
    parts += [f"the torque of {joint_name(way.joint)} comes {_way(way)}" for way in found.own]
    return parts[0][0].upper() + ", and ".join(parts)[1:]


def _way(way: OwnWay) -> str:
    if way.filters:
        return f"through a low pass of about {way.corner:.2g} Hz"
    return f"about {_late(way.late)}"


def _late(time: float) -> str:
    return f"{1e3 * abs(time):.2g} ms {'late' if time > 0 else 'early'}"


def in_motion(search: Search, places: Sequence[Place]) -> list[Place]:
    """Without the motor sides of joints that stand still, where friction may hold any torque."""
    still = standing_in([log.part.motion for log in search.examination.logs], len(search.robot.joints))
    parked = {(joint_name(k), "motor") for k in still}
    return [place for place in places if (place.joint, place.balance) not in parked]


def warnings(search: Search, verdict: str, places: Sequence[Place]) -> Iterator[str]:
    """What makes a verdict worth less than it seems."""
    rules = search.rules
    weak = [p for p in places if p.floor_percent > 100 * rules.worthless]
    if weak and verdict == "nothing_detectable":
        worst = max(weak, key=lambda p: p.floor_percent)
        yield (
            f"this says little: replicas leave {worst.floor_percent:.0f} % of the torque of {worst.joint} "
            f"unexplained; {lowered_by(search.examination, joint_number(worst.joint) - 1)}"
        )
    quiet = [p for p in places if p.over_floor[0] < rules.below_floor and p.state != "unobserved"]
    if quiet and not search.examination.setting.unfollowed:
        listed = ", ".join(f"{p.joint}, {p.balance} side ({p.over_floor[0]:.2g} times)" for p in quiet)
        yield (
            f"the residual lies below its floor at {listed}: the replicas are noisier than the log "
            "there, and hide what is smaller than their floor"
        )


def of_what_is_shared(places: Sequence[Place], findings: Sequence[Finding]) -> Iterator[str]:
    """Where nearly every joint stays unexplained: one cause in common is likelier than as many."""
    motors = [p for p in places if p.balance == "motor" and p.state != "unobserved"]
    left = [p for p in motors if p.state == "unexplained" and _mostly_left(p)]
    if len(left) < max(_MANY, _MOST * len(motors)):
        return
    who = "every joint is" if len(left) == len(motors) else f"{len(left)} of {len(motors)} joints are"
    but = "; what is named may only stand in for it" if findings else ""
    yield (
        f"{who} left unexplained: suspect first what they share, as torque sensors with hysteresis or of a "
        "wrong scale, the recorder's clock or filter, lengths and gravity in the robot file, a base that "
        f"gives way, a load taken up, or something touched, in a part of the logs{but}"
    )


def of_drifts(findings: Sequence[Finding]) -> Iterator[str]:
    """Where friction and zeros of many joints drift: one cause in common is likelier than as many."""
    names = [f.tie[0] for f in findings if f.tie[0].effect.endswith("_drift")]
    joints = {name.joint for name in names}
    if len(joints) >= _MANY:
        yield (
            f"{len(names)} drifts at {len(joints)} joints: suspect first what they share, as a supply, or "
            "torque constants that fall while motors warm up: then inertia and gravity seem to fall as well"
        )


def _mostly_left(place: Place) -> bool:
    """Whether the findings take less than half of what exceeds the floor."""
    before, after = (ratio**2 - 1 for ratio in place.over_floor)
    return after >= 0.5 * before


def in_doubt(beside: Search, places: Sequence[Place], refusals: Sequence[Refusal]) -> Iterator[str]:
    """Where slow noise may be all that exceeds the floor, or not: no more than may rise unmeasured.

    refusals   what comes nearest by place
    """
    ex, doubted = beside.examination, _doubted(beside, places)
    ends = (*EDGES, float(ex.floor.frequencies[-1]))
    rows = np.flatnonzero(doubted.any(axis=1))
    said = []
    for row in rows:
        band, c = int(np.argmax(doubted[row])), beside.robot.q[row]
        said.append(
            f"{joint_name(c.joint)}, {c.side} side ({doubted[row, band]:.2g} times from {ends[band]:g} to "
            f"{ends[band + 1]:.3g} Hz)"
        )
    if said:
        lowest = ex.setting.continued[:, rows].min()
        there = [r for r in refusals if not set(r.region.rows).isdisjoint(rows.tolist())]
        nearest = max(there, key=lambda r: r.share_percent, default=None)
        name = nearest and f"{nearest.candidate.effect} at joint{nearest.candidate.joint}"
        why = f"; {name} comes nearest, but {nearest.reason}" if nearest else ""
        yield (
            f"the residual exceeds its floor at {', '.join(said)}: slow noise of a torque may do that, which "
            f"these logs do not show below {lowest:.2g} Hz, or something small that is missing"
            f"{why}; a log of a motion that repeats would tell"
        )


def of_bursts(beside: Search, found: Mapping[int, Bursts]) -> Iterator[str]:
    """Where noise comes in bursts, by row: the floor holds them."""
    for row, own in found.items():
        joint, source = joint_name(beside.robot.q[row].joint), beside.examination.setting.logs[own.log].source
        count = f"{own.count} bursts" if own.count > 1 else "one burst"
        yield (
            f"what is left of the torque of {joint} is no steady noise: {100 * own.share:.0f} % of it below "
            f"{SLOW:.0f} Hz lies in {count}, the strongest at {own.start:.0f} s of {source}; did something "
            "touch the arm? The floor holds them, and hides what is smaller"
        )


def doubted_joints(beside: Search, places: Sequence[Place]) -> list[str]:
    """Joints at which slow noise may be all that exceeds the floor, or not."""
    rows = np.flatnonzero(_doubted(beside, places).any(axis=1))
    return list(dict.fromkeys(joint_name(beside.robot.q[row].joint) for row in rows))


def _doubted(beside: Search, places: Sequence[Place]) -> np.ndarray:
    """(n, bands): times that a residual exceeds its floor as slow noise may, else 0."""
    ex, ratio = beside.examination, in_bands(beside.examination, beside.base).ratio
    doubted = np.where(bands_in_doubt(ex, beside.base), np.sqrt(ratio), 0.0)
    doubted[[p.state == "unexplained" for p in places]] = 0.0  # something held-out logs show, too
    return doubted


def of_time(setting: Setting) -> Iterator[str]:
    """How positions that come late, or torques that are smeared, are mended."""
    found = setting.alignment
    if found.held:
        yield 'torques that are held: derivative = "hat" under [processing] in the robot file says it'
    if np.isfinite(found.corner):
        yield (
            "all torques were taken as before a low pass that the positions did not pass, of "
            f"order {found.poles} at about {found.corner:.2g} Hz{', without delay' if found.twice else ''}, "
            "which raises their noise above; log them without it"
        )
    if found.delayed:
        held = _by_hold(setting, -found.late, "torques are ")
        yield (
            "all positions were moved in time before anything was judged: they have another clock or filter "
            f"than the torques, or all drives lag by that much{held}; give their "
            f"columns a delay of about {found.late:.2g} s in the mapping"
        )
    for way in found.own:
        yield (
            f"the torque of {joint_name(way.joint)} was put right before all was judged: it has a clock or a "
            f"filter of its own{_by_hold(setting, way.behind)}; give joint{way.joint}.tau a delay of about "
            f"{way.behind:.2g} s in the mapping"
            + (", or log it without that filter, which smears friction as well" if way.filters else "")
        )


def _by_hold(setting: Setting, late: float, what: str = "is ") -> str:
    """That a torque is logged before it acts because its loop holds it; empty where that is not enough."""
    return f", or {what}held until the next sample" if -HELD * setting.period <= late < 0 else ""


def of_one_order(search: Search, selection: Selection, held: HeldOut) -> Iterator[str]:
    """Ripples of which held-out logs bear out the order alone (see `same_order`)."""
    for step in selection.steps:
        best = step.best.candidate
        view = search.resting_on(others_than(step, selection.steps))
        if not same_order(view, best, held):
            continue
        region = region_of(view, best)
        unseen, share = held.share(view, step.candidates, region), share_in(view, step.candidates, region)
        if unseen is not None and not held.holds(unseen, share, search.rules):
            yield (
                f"{best.effect} at joint{best.joint}: held-out logs show the same order, with another size "
                "and phase; a loop answers a fast ripple the less the faster the joint turns, so that its "
                "size is that of these logs' speeds"
            )


def of_speeds(search: Search, selection: Selection) -> Iterator[str]:
    """Ripples that have a size of their own at every speed: what these are."""
    for step in selection.steps:
        best = step.best.candidate
        if not best.speeds:
            continue
        view = search.resting_on(others_than(step, selection.steps))
        waves = view.gain_of(best).coefficients.reshape(-1, len(best.speeds))
        sizes = np.sqrt(np.square(waves).sum(axis=0))
        least, most = int(np.argmin(sizes)), int(np.argmax(sizes))
        unit, *_ = units_of(search.robot, best).values()
        speeds = np.abs(best.speeds)
        yield (
            f"{best.effect} at joint{best.joint}: its size and phase are those of the speed, as where an arm "
            f"shakes or a loop answers: from {sizes[least]:.2g} {unit} at {speeds[least]:.2g} rad/s to "
            f"{sizes[most]:.2g} {unit} at {speeds[most]:.2g} rad/s; the parameters named are those at the "
            "joint's mean speed, and a law with these at all speeds takes less"
        )


def of_gears(findings: Sequence[Finding]) -> Iterator[str]:
    """Where a gain of the torque may be a gear's: friction under a load F that is larger while the motor
    drives it is μ |F| sign(v) + μ' F, and no bodies are larger by μ' for one joint alone.
    """
    named = {(n.effect, n.joint) for f in findings for n in f.tie}
    for joint in sorted({joint for effect, joint in named if effect == "torque_gain"}):
        if {(law, joint) for law in _OF_LOAD} & named:
            yield (
                f"{joint} has friction under its load: a gear that loses more while it drives than while it "
                "is driven looks like a gain of its logged torque"
            )


def of_ends(robot: Robot, findings: Sequence[Finding]) -> Iterator[str]:
    """Where a law has a value that it may hardly have: a force of another form stretches it there."""
    for n in (n for f in findings for n in f.tie if not n.describes):
        joint = joint_number(n.joint)
        for p in robot.joints[joint - 1].law(n.effect).nonlinear:
            value, (lower, upper) = n.values.get(p.name, np.nan), _ends(robot, joint, p)
            width = upper - lower
            near = min(abs(value - lower), abs(upper - value)) < _AT_END * width
            if np.isfinite(width) and not np.isclose(width, 2 * np.pi) and near:
                yield (
                    f"{n.effect} at {n.joint}: its {p.name}, {value:.3g}, lies at the end of what it may be; "
                    "so the law may stand in for a force of another form"
                )


def _ends(robot: Robot, joint: int, p: Parameter) -> tuple[float, float]:
    """Between which values a nonlinear parameter is looked for in every log."""
    if p.periodic or counted_along_motion(robot, joint, p):
        return p.lower, p.upper
    least = min(p.grid)
    return max(p.lower, min(least / BEYOND, least * BEYOND)), min(p.upper, BEYOND * max(p.grid))


def of_springs(findings: Sequence[Finding]) -> Iterator[str]:
    """Where what is named a spring pushes its joint away: no spring does."""
    for n in (n for f in findings for n in f.tie if n.effect == joint_spring.name):
        if n.values["stiffness"] < 0:
            yield (
                f"{n.effect} at {n.joint}: its stiffness is below zero, as of a balancer, a rope over the "
                "joint or gravity that is tilted in the robot file, not of a spring"
            )


def of_mends(findings: Sequence[Finding]) -> Iterator[str]:
    """Where an error is put right that no robot file states."""
    for finding in findings:
        which = "" if len(finding.tie) == 1 else "if it is that, "
        for n in finding.tie:
            if (outside := outside_file(n.effect)) is not None:
                by = outside.by(joint_number(n.joint), n.values["correction"], n.units["correction"])
                yield f"{n.effect} at {n.joint}: {which}{by}"
