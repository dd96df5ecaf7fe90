"""Whether the robot file is wrong: errors of the description beside the laws, named by the same gate.

They are ranked among themselves once the laws are chosen. One that explains what a law was named for joins
its tie, or takes its place if it explains more. Then the best one beside what stands is named if it takes as
much as a name needs. Where the logs hardly exceed the floor, held-out logs must show it far beyond chance and
at its size: a gain of a torque takes what no replica shows of almost any log. Where nothing stands out and no
law is named, an error is that both measure (see `measured`), in a tie with a law that both measure, too.

None is named while anything else stands out: what a model lacks at one joint bends the parameters of all, and
a gain of another's torque then bends them back. It is a note at most, where its equations exceed the floor.
Nor is one that takes a small part of what an error of another kind took, whose slope may leave as much.
A gain, a ratio or a drive takes a share of whatever the torque holds, and unless it takes most of all that is
missing it is not named either beside what slow noise alone may excuse.
But one that leaves hardly anything of all that is missing is named, and so are several of one kind, as drives
that bend, where they explain what a set of laws must: a slope does not describe a large error to the last.

What else the model lacks, and noise in closed loop, bend the value of an error by more than its standard
deviation says (2 mm of a link were read as 1.6 and 2.6 mm), so that none is given.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pyident.conditioning.standing import standing_in
from pyident.diagnosis.base.candidates import Candidate, bounds, described, units_of
from pyident.diagnosis.base.standing_out import unsettled
from pyident.diagnosis.imitators.constancy import changes_with
from pyident.diagnosis.search.found import Found, Step, candidates_of, others_than
from pyident.diagnosis.search.gate import Admission, admission, region_of, share_in
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.measured import can_be, measured, tells_errors, worth_name
from pyident.diagnosis.search.search import Search, search_of
from pyident.diagnosis.search.selection import Selection
from pyident.regression.descriptions import outside_file, place_name

_STRANGE = 0.3  # of a gain or a ratio: what needs more is something else


def with_descriptions(search: Search, selection: Selection, held: HeldOut) -> Selection:
    """The selection with errors of the robot's description that held-out logs bear out."""
    still = standing_in([log.part.motion for log in search.examination.logs], len(search.robot.joints))
    listed = described(search.robot, still, search.examination.setting.bends)
    if not listed:
        return selection
    among = search_of(search.examination.of_others(listed))
    steps, imitators = list(selection.steps), dict(selection.imitators)
    for step in selection.steps:
        if step.best.candidate.describes:
            continue
        view = among.resting_on(others_than(step, steps))
        rivals = _rivals(view, step, held)
        if rivals is None:
            continue
        share, of_error = _shares(view, step, rivals.best)
        if share >= search.rules.tie * of_error:
            first = step.best.excess >= search.rules.tie * rivals.best.excess  # over all equations
            rivals = replace(step, tie=(*step.tie, *rivals.tie) if first else (*rivals.tie, *step.tie))
        else:
            takes = f"it takes {100 * share:.0f} %, an error of {_place(rivals.best)} {100 * of_error:.0f} %"
            imitators[_named(step)] = takes
        steps[steps.index(step)] = rivals
    further, notes = _beside(among, steps, held, selection.first.best)
    for at, step in enumerate(steps):
        steps[at] = _kin_of(step, [*steps[:at], *steps[at + 1 :], *further], among, held)
    steps, needless = _needed(steps, further, among, held)
    return replace(selection, steps=(*steps, *further), imitators=imitators | needless, notes=notes)


def _rivals(view: Search, step: Step, held: HeldOut) -> Step | None:
    """Errors that explain what a law was named for, and as much; the view rests on all other laws."""
    rules, law, errors = view.rules, step.best, view.step()
    best = errors.best
    share, of_error = _shares(view, step, best)
    if not _sized(view, best, of_error) or admission(view, best, [best.candidate], held).reason:
        return None
    beside = view.with_further([best.candidate])
    if of_error < rules.tie * share or not _same(beside, law):
        return None
    if beside.stands_out or changes_with(beside, best.candidate):
        return None
    return errors


def _needed(
    steps: Sequence[Step], errors: Sequence[Step], among: Search, held: HeldOut
) -> tuple[list[Step], dict[str, str]]:
    """Without laws that errors beside them have made needless; and why these are gone."""
    kept, gone = list(steps), {}
    for step in [s for s in steps if errors and not s.best.candidate.describes]:
        view = among.resting_on(candidates_of([*(s for s in kept if s is not step), *errors]))
        if _needless(view, step.best, held):
            kept.remove(step)
            places = ", ".join(_place(s.best) for s in errors)
            gone[_named(step)] = f"errors of {places} take what it took"
    return kept, gone


def _needless(view: Search, law: Found, held: HeldOut) -> bool:
    """Whether errors that were named beside a law take what it took; the view rests on them."""
    return _same(view, law) and bool(admission(view, law, [law.candidate], held).reason)


def _kin_of(step: Step, others: Sequence[Step], among: Search, held: HeldOut) -> Step:
    """An error along another axis than one that is named, where it takes as much as a law; else the law.

    A base that is tilted about two axes is two errors; a spring at its first joint takes what that joint
    shows of both.
    """
    named = [s.best.candidate for s in others if s.best.candidate.describes]
    law = step.best.candidate
    if law.describes or not named:
        return step
    view = among.resting_on(candidates_of(others))
    rivals = _rivals(view, step, held)
    if rivals is None or not any(_of_one_place(rivals.best.candidate, c) for c in named):
        return step
    more = rivals.best.gain.energy >= view.gain_of(law).energy
    return rivals if more else replace(step, tie=(*step.tie, *rivals.tie))


def _of_one_place(error: Candidate, other: Candidate) -> bool:
    """Whether two errors are of one quantity at one joint, along two axes."""
    return error.joint == other.joint and error.effect.partition("[")[0] == other.effect.partition("[")[0]


def _shares(view: Search, step: Step, error: Found) -> tuple[float, float]:
    """What a law and an error take of what exceeds the floor on the law's equations."""
    region = region_of(view, step.best.candidate)
    return share_in(view, step.candidates, region), share_in(view, [error.candidate], region)


def _sized(view: Search, error: Found, share: float) -> bool:
    """Whether its value lies where its column, a slope, holds, and is worth a name; one ahead of its time, of
    a torque that comes early, only if it takes hardly less than all.
    """
    lower, upper = bounds(view.robot, error.candidate)
    value = error.gain.coefficients
    inside = bool(np.all((value > lower) & (value < upper)))
    sound = can_be(error.candidate, value) or share >= view.rules.whole
    return inside and sound and worth_name(view, error.candidate, value)


def _beside(
    among: Search, steps: Sequence[Step], held: HeldOut, law: Found
) -> tuple[list[Step], tuple[str, ...]]:
    """Errors that are named beside what stands, one after the other; and what is said of the next.

    law   that explains most with none named
    """
    named: list[Step] = []
    pending: list[Step] = []
    told: tuple[str, ...] = ()
    lacking = among.resting_on(candidates_of(steps)).lacking.sum()
    while len(steps) + len(named) + len(pending) < among.rules.most:
        view = among.resting_on(candidates_of([*steps, *named, *pending]))
        step = _worth_names(view, view.step())
        entry = admission(view, step.best, [step.best.candidate], held)
        nameable = (
            _sized(view, step.best, entry.share)
            and _alike(step, pending)
            and not _left_by_slopes(view, step, named)
        )
        if entry.reason or not entry.region.rows or not nameable:
            break
        exceeds, beside = _exceeds(view, entry), view.with_further([step.best.candidate])
        settled = _settled(beside, step.best, lacking)
        if entry.measured and not steps and not pending and settled:
            named.append(_with_law(view, step, law, held) if _instead(beside, law, step.best) else step)
            continue
        doubt = changes_with(beside, step.best.candidate)
        if exceeds and not told and _believable(view, step):
            told = (_told(view, step, entry, doubt),)
        if doubt or entry.share < view.rules.explained[0] or not (exceeds or _no_chance(view, entry)):
            break
        pending.append(step)
        enough = view.rules.whole if len(pending) == 1 else view.rules.explained[-1]
        if settled or beside.lacking.sum() <= (1 - enough) * lacking:
            named, pending, told, lacking = [*named, *pending], [], (), beside.lacking.sum()
    return _told_apart(named), told


def _worth_names(view: Search, step: Step) -> Step:
    """Without rivals whose values no slope holds for, or that are too small for a name."""
    return replace(step, tie=tuple(f for f in step.tie if f is step.best or _sized(view, f, 0.0)))


def _told_apart(named: Sequence[Step]) -> list[Step]:
    """Without rivals that are named by themselves beside what they tied with."""
    firsts = {s.best.candidate for s in named}
    kept = [tuple(f for f in s.tie if f is s.best or f.candidate not in firsts) for s in named]
    return [replace(s, tie=tie) for s, tie in zip(named, kept, strict=True)]


def _alike(step: Step, pending: Sequence[Step]) -> bool:
    """Whether an error is of the kind of those that leave something together, or of one quantity."""
    own = step.best.candidate
    return all(own.effect == s.best.candidate.effect or _of_one_place(own, s.best.candidate) for s in pending)


def _settled(beside: Search, error: Found, lacking: float) -> bool:
    """Whether nothing stands out beside an error; of one outside the file, not even what noise may excuse,
    unless the error takes most of all that was lacking.
    """
    outside = outside_file(error.candidate.effect) is not None
    if not outside or beside.lacking.sum() <= beside.rules.apart * lacking:
        return not beside.stands_out
    return not unsettled(beside.examination, beside.base)


def _left_by_slopes(view: Search, step: Step, named: Sequence[Step]) -> bool:
    """Whether an error of another kind may be what slopes leave of those that are named."""
    taken = max((s.best.gain.energy for s in named), default=0.0)
    return not _alike(step, named) and step.best.gain.energy < view.rules.part * taken


def _instead(beside: Search, law: Found, error: Found) -> bool:
    """Whether a law may be what is missing in place of an error: it takes as much, and little beside it."""
    return law.excess >= beside.rules.tie * error.excess and _same(beside, law)


def _same(beside: Search, law: Found) -> bool:
    """Whether what the view rests on takes most of what a law took."""
    return beside.gain_of(law.candidate).energy < beside.rules.apart * law.gain.energy


def _with_law(view: Search, errors: Step, law: Found, held: HeldOut) -> Step:
    """Errors with the law that may stand in their place, if held-out logs show it as they show those."""
    unseen = held.share(view, [law.candidate], region_of(view, law.candidate))
    if not measured(view, law.candidate, unseen):
        return errors
    first = law.excess > errors.best.excess / view.rules.tie
    return replace(errors, tie=(law, *errors.tie) if first else (*errors.tie, law))


def _exceeds(view: Search, entry: Admission) -> bool:
    """Whether the logs exceed the floor where an error acts, held-out ones too; by far where motions keep
    their noise, which bends the column.
    """
    if not tells_errors(view) and not view.stands_out_in(entry.region):
        return False
    excess = view.over_floor[list(entry.region.rows)].mean() - 1
    if entry.unseen is not None:
        excess = min(excess, entry.unseen.excess)
    return bool(excess >= view.rules.unseen_excess)


def _no_chance(view: Search, entry: Admission) -> bool:
    """Whether held-out logs show an error far beyond chance, and of about the same size."""
    unseen, rules = entry.unseen, view.rules
    if unseen is None or not tells_errors(view):
        return False
    return unseen.share > rules.chance * unseen.std and unseen.of_one_size(rules)


def _believable(view: Search, step: Step) -> bool:
    """Whether none of a tie is a gain or a ratio that is farther off than one of a file is."""
    factors = [f for f in step.tie if set(units_of(view.robot, f.candidate).values()) == {"1"}]
    return all(np.abs(f.gain.coefficients).max() <= _STRANGE for f in factors)


def _told(view: Search, step: Step, entry: Admission, doubt: str) -> str:
    """Of an error that takes too little for a name, or not the same everywhere."""
    listed = " or ".join(
        f"{_place(f)} (by about {f.gain.coefficients[0]:.2g}{'' if unit == '1' else f' {unit}'})"
        for f in step.tie
        for unit in units_of(view.robot, f.candidate).values()
    )
    share = f"{100 * entry.share:.0f} %"
    if entry.unseen is not None:
        share += f", on held-out data {entry.unseen},"
    but = f"; but its value changes with {doubt}, as that of an imitator does" if doubt else ""
    return (
        f"the robot file may be wrong in {listed}: more than any replica shows, it takes {share} of what "
        f"exceeds the floor there{but}"
    )


def _named(step: Step) -> str:
    return f"{step.best.candidate.effect} at joint{step.best.candidate.joint}"


def _place(found: Found) -> str:
    return place_name(found.candidate.joint, found.candidate.effect)
