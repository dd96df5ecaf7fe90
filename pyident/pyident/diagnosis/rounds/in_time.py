"""Positions and torques that belong together only beside what is named: all, or single torques."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from pyident.conditioning.alignment import NOTHING, Alignment
from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.late_torque import comes_late, held_alike, less_left, own_ways
from pyident.diagnosis.misaligned import delay_beside
from pyident.diagnosis.rounds.asked import Asked, selected
from pyident.diagnosis.search.held_out import held_out
from pyident.diagnosis.search.search import Search
from pyident.diagnosis.searched import UnsimulatedFitError, part_of, put_right
from pyident.logs.log import Log
from pyident.simulation.simulator import OpenPool

Progress = Callable[[float], None]


def in_time(search: Search, heldout: Sequence[Log], open_pool: OpenPool, progress: Progress) -> Asked:
    """What the laws come to; with all torques put right that are late alike beside them, and single ones
    where that leaves far less.
    """
    held = held_out(search, heldout)
    selection = selected(search, held)
    for asked, apart in enumerate((_late_alike, _each_its_way, _others_alike), start=1):
        told = part_of(progress, 0.25 * asked, 0.25)
        told(0.0)
        further = apart(search, selection.candidates)
        if further.needed:
            try:
                again = put_right(search.examination.setting, further, open_pool, told)
            except UnsimulatedFitError:  # it stays as it was
                continue
            if apart is _each_its_way and not less_left(search, again, further, selection.candidates):
                continue
            search, held = again, held_out(again, heldout)
            selection = selected(search, held)
    return search, held, selection


def _late_alike(search: Search, named: Sequence[Candidate]) -> Alignment:
    """What keeps all positions and torques apart beside what was named; with no name it was asked before."""
    return _beside(search, named) if named else NOTHING


def _each_its_way(search: Search, named: Sequence[Candidate]) -> Alignment:
    """What single torques went through; or that a loop holds them all."""
    return replace(held_alike(search, named), own=own_ways(search, named))


def _others_alike(search: Search, named: Sequence[Candidate]) -> Alignment:
    """What keeps positions and all other torques apart, once single ones were put right."""
    return _beside(search, named) if search.examination.setting.alignment.own else NOTHING


def _beside(search: Search, named: Sequence[Candidate]) -> Alignment:
    others = [c for c in named if not comes_late(search.robot, c)]
    return delay_beside(search.examination, others, len(others) < len(named))
