"""A log in which a load was taken up or put down, as two: a model has one last link for all of a log."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from pyident.checks.defect import Defect
from pyident.logs.log import Log

_LEAST = 0.1  # of a log, that a part of it must be


def instants(logs: Sequence[Log], defects: Sequence[Defect]) -> dict[str, float]:
    """Source -> time [s] from which its last link has another body; of logs that have a name of their own.

    defects   of these logs
    """
    named = Counter(log.source for log in logs)
    times = dict(defect.another_body for defect in defects if defect.another_body is not None)
    return {source: time for source, time in times.items() if named[source] == 1}


def divided(logs: Sequence[Log], times: Mapping[str, float]) -> tuple[list[Log], tuple[str, ...]]:
    """Logs, each as two at the time of its source in `times`, and a sentence on each."""
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
