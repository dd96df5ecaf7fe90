"""Whether the robot file may be wrong: offered beside the verdict, which laws alone decide.

Errors of the description are ranked among themselves, with what was named in the base. The best one is told
if it passes the gate where logs, held-out ones too, exceed the floor: elsewhere a gain of a torque takes what
no replica shows of almost any log. A name would need more: what else the model lacks, and
noise in closed loop, bend the value by more than its standard deviation says (2 mm of a link were read as 1.6
and 2.6 mm), so that none is printed.
"""

from collections.abc import Iterator, Sequence

from pyident.diagnosis.base.candidates import described, units_of
from pyident.diagnosis.search.constancy import changes_with
from pyident.diagnosis.search.gate import admission, counts
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Found, Search, Step, search_of
from pyident.diagnosis.search.selection import Selection
from pyident.regression.descriptions import place_name


def wrong_descriptions(search: Search, selection: Selection, held: HeldOut) -> Iterator[str]:
    """Sentences about errors of the robot's description."""
    if not selection.steps and search.over_floor.max() < 1 + search.rules.unseen_excess:
        return  # nothing is left for them to explain, and their columns cost more than all laws'
    listed = described(search.robot)
    if not listed:
        return
    among = search_of(search.examination.of_others(listed))
    yield from _beside(among.resting_on(selection.candidates), held)
    for step in selection.steps:
        others = [c for s in selection.steps if s is not step for c in s.candidates]
        yield from _rivals(among.resting_on(others), step)


def _beside(view: Search, held: HeldOut) -> Iterator[str]:
    """The best one beside what was named, if it passes the gate where something is left to explain."""
    step = view.step()
    lead = step.best
    entry = admission(view, lead, [lead.candidate], held)
    if entry.reason or not entry.rows:
        return
    excess = view.over_floor[list(entry.rows)].mean() - 1
    if entry.unseen is not None:
        excess = min(excess, entry.unseen.excess)
    if excess < view.rules.unseen_excess:
        return
    share = f"{100 * entry.share:.0f} %"
    if entry.unseen is not None:
        share += f", on held-out data {entry.unseen},"
    yield (
        f"the robot file may be wrong in {_named(view, step.tie)}: more than any replica shows, it takes "
        f"{share} of what exceeds the floor there{_doubt(view, lead)}"
    )


def _rivals(view: Search, step: Step) -> Iterator[str]:
    """Descriptions that explain as much as a law that was named."""
    least = view.rules.tie * step.best.excess
    rivals = [f for f in view.step().ranked if f.excess >= least and counts(view, f)]
    if rivals:
        law = step.best.candidate
        yield (
            f"what {law.effect} at joint{law.joint} explains, a robot file that is wrong in "
            f"{_named(view, rivals)} would explain as well"
        )


def _named(view: Search, listed: Sequence[Found]) -> str:
    return " or ".join(
        f"{place_name(f.candidate.joint, f.candidate.effect)} (by about {f.gain.coefficients[0]:.2g} {unit})"
        for f in listed
        for unit in units_of(view.robot, f.candidate).values()
    )


def _doubt(view: Search, lead: Found) -> str:
    quantity = changes_with(view.with_further([lead.candidate]), lead.candidate)
    return f"; but its value changes with {quantity}, as that of an imitator does" if quantity else ""
