"""A log in which a load was taken up or put down, as two: a model has one last link for all of a log."""

from collections.abc import Sequence
from dataclasses import replace

from pyident.checks.defect import Defect
from pyident.logs.log import Log

_LEAST = 0.1  # of a log, that a part of it must be


def divided(logs: Sequence[Log], defects: Sequence[Defect]) -> tuple[list[Log], tuple[str, ...]]:
    """Logs, each as two where its last link has another body from some time on, and a sentence on each.

    defects   of these logs
    """
    times = dict(defect.another_body for defect in defects if defect.another_body is not None)
    out: list[Log] = []
    said: list[str] = []
    for log in logs:
        at = int(log.frame["time"].searchsorted(times.get(log.source, float("inf"))))
        if min(at, len(log) - at) < max(_LEAST * len(log), 2):
            out.append(log)
            continue
        when = f"{round(float(log.frame['time'].iloc[at]), 3):.13g} s"
        first, second = (log.frame.iloc[part].reset_index(drop=True) for part in (slice(at), slice(at, None)))
        out.append(replace(log, frame=first, source=f"{log.source} before {when}"))
        after = log.after + at * log.period
        out.append(replace(log, frame=second, source=f"{log.source} from {when} on", after=after))
        said.append(
            f"{log.source} counts as two logs, before and from {when} on: the last link changes there"
        )
    return out, tuple(said)
