"""What a search has come to: round after round it is asked again, with more put right."""

from collections.abc import Sequence

from pyident.diagnosis.search.found import Step, others_than
from pyident.diagnosis.search.gate import region_of, share_in
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.search.selection import Selection, select
from pyident.diagnosis.search.wrong_description import with_descriptions

Asked = tuple[Search, HeldOut, Selection]


def selected(search: Search, held: HeldOut, given: Sequence[Step] = ()) -> Selection:
    """What laws and errors come to in a search that rests on nothing.

    given   steps with which to begin
    """
    return with_descriptions(search, select(search, held, given), held)


def take_all(search: Search, steps: Sequence[Step], asked: Sequence[Step]) -> bool:
    """Whether each of the `asked` takes all that is missing where it acts, beside the other steps."""
    for step in asked:
        view = search.resting_on(others_than(step, steps))
        if share_in(view, step.candidates, region_of(view, step.best.candidate)) < search.rules.whole:
            return False
    return True
