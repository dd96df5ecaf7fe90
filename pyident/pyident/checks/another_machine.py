"""A log of another machine than the one before: with a load or a tool that the other has not.

One set of parameters is fitted to all logs, or judged by one that was held out. Whoever picks something up
between two logs gets an average of two machines, or a model that does not hold, without a word about why. So
the logs are joined, and asked for a step at their border, as one log is for a step within
(`checks.changes`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pyident.checks.balances import Balances, balances_of
from pyident.checks.changes import Change, grown, last_body, one_machine, step_at
from pyident.checks.defect import Defect


def another_machine(logs: Sequence[tuple[str, Balances]]) -> Iterator[Defect]:
    """A defect per log whose last link has another body than that of the first. logs: source, balances."""
    for source, other in logs[1:]:
        first, of = logs[0]
        if (found := carried_otherwise(of, other)) is not None:
            yield _defect(source, first, found)


def carried_otherwise(first: Balances, second: Balances) -> Change | None:
    """The last link's step from one log to another, if there is one."""
    both = joined(first, second)
    one = one_machine(both)
    body = None if one is None else last_body(both, one)
    if one is None or body is None:
        return None
    return step_at(both, one, body, len(first.samples.at))


def joined(first: Balances, second: Balances) -> Balances:
    """The balances of two logs of one robot, one after the other."""
    a, b = first.samples, second.samples
    names = ("q", "dq", "ddq", "tau", "direction", "use")
    arrays = {name: np.concatenate([getattr(a, name), getattr(b, name)]) for name in names}
    both = replace(a, at=np.concatenate([a.at, b.at + len(a.tau)]), **arrays)
    return balances_of(both, np.concatenate([first.Phi, second.Phi]), first.columns)


def _defect(source: str, first: str, found: Change) -> Defect:
    return Defect("doubtful", "change", "",
                  f"{source}: the last link has another body than in {first}{grown(found, 'kg')}: a load "
                  f"or a tool. With one for either log {max(100 * found.left, 1):.0f} % of the residual are "
                  "left. Fit the logs apart, or identify the load from both (pyident payload)")  # fmt: skip
