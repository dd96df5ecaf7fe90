"""Whether the robot file is wrong: errors of the description beside the laws, named by the same gate.

They are ranked among themselves once the laws are chosen. One that explains what a law was named for joins
its tie, or takes its place if it explains more. Then the best one beside what stands is named if it takes as
much as a name needs. Where the logs hardly exceed the floor, held-out logs must show it far beyond chance: a
gain of a torque takes what no replica shows of almost any log.

What else the model lacks, and noise in closed loop, bend the value of an error by more than its standard
deviation says (2 mm of a link were read as 1.6 and 2.6 mm), so that none is given.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from pyident.diagnosis.base.candidates import Candidate, described, units_of
from pyident.diagnosis.search.constancy import changes_with
from pyident.diagnosis.search.gate import Admission, admission
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Found, Search, Step, search_of
from pyident.diagnosis.search.selection import Selection
from pyident.regression.descriptions import place_name


def with_descriptions(search: Search, selection: Selection, held: HeldOut) -> Selection:
    """The selection with errors of the robot's description that held-out logs bear out."""
    listed = described(search.robot)
    if not listed:
        return selection
    among = search_of(search.examination.of_others(listed))
    steps, imitators = list(selection.steps), dict(selection.imitators)
    for step in selection.steps:
        others = _candidates(s for s in steps if s is not step)
        rivals = _rivals(among.resting_on(others), step, held)
        if not rivals:
            continue
        law, place = step.best.candidate, _place(rivals[0])
        if step.best.excess >= search.rules.tie * rivals[0].excess:
            tie = sorted((*step.tie, *rivals), key=lambda f: -f.excess)
            steps[steps.index(step)] = replace(step, tie=tuple(tie))
        else:
            steps.remove(step)
            imitators[f"{law.effect} at joint{law.joint}"] = f"an error of {place} explains more"
    further, notes = _beside(among, steps, held)
    return replace(selection, steps=(*steps, *further), imitators=imitators, notes=notes)


def _rivals(view: Search, step: Step, held: HeldOut) -> tuple[Found, ...]:
    """Errors that explain what a law was named for, and as much; the view rests on all other laws."""
    rules, law, errors = view.rules, step.best, view.step()
    best = errors.best
    if best.excess < rules.tie * law.excess or admission(view, best, [best.candidate], held).reason:
        return ()
    beside = view.with_further([best.candidate])
    same = beside.gain_of(law.candidate).energy < rules.apart * law.gain.energy
    return errors.tie if same and not changes_with(beside, best.candidate) else ()


def _beside(among: Search, steps: Sequence[Step], held: HeldOut) -> tuple[list[Step], tuple[str, ...]]:
    """Errors that are named beside what stands, one after the other; and what is said of the next."""
    named: list[Step] = []
    while len(steps) + len(named) < among.rules.most:
        view = among.resting_on(_candidates([*steps, *named]))
        step = view.step()
        entry = admission(view, step.best, [step.best.candidate], held)
        if entry.reason or not entry.rows or not _shown(view, entry):
            break
        doubt = changes_with(view.with_further([step.best.candidate]), step.best.candidate)
        if doubt or entry.share < view.rules.explained[0]:
            return named, (_told(view, step, entry, doubt),)
        named.append(step)
    return named, ()


def _shown(view: Search, entry: Admission) -> bool:
    """Whether the logs exceed the floor, held-out ones too; or these show the error far beyond chance."""
    rules, unseen = view.rules, entry.unseen
    excess = view.over_floor[list(entry.rows)].mean() - 1
    if unseen is None:
        return excess >= rules.unseen_excess
    return min(excess, unseen.excess) >= rules.unseen_excess or unseen.share > rules.chance * unseen.std


def _told(view: Search, step: Step, entry: Admission, doubt: str) -> str:
    """Of an error that takes too little for a name, or not the same everywhere."""
    listed = " or ".join(
        f"{_place(f)} (by about {f.gain.coefficients[0]:.2g} {unit})"
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


def _place(found: Found) -> str:
    return place_name(found.candidate.joint, found.candidate.effect)


def _candidates(steps: Iterable[Step]) -> list[Candidate]:
    return [c for step in steps for c in step.candidates]
