"""Which data an added effect is fitted to, and on which it is judged."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pyident.logs.log import Log, LogError
from pyident.rules.rules import RULES, Rules


@dataclass(frozen=True)
class Split:
    """Logs to fit, logs to judge, and per judged log the time [s] from which on it counts."""

    fitted: list[Log]
    judged: list[Log]
    since: tuple[float, ...]

    @property
    def unseen(self) -> list[Log]:
        """What counts of the logs to judge."""
        starts = [round(t / log.period) for log, t in zip(self.judged, self.since, strict=True)]
        return [
            replace(log, frame=log.frame.iloc[n:].reset_index(drop=True), after=log.after + n * log.period)
            for log, n in zip(self.judged, starts, strict=True)
        ]


def split(logs: Sequence[Log], heldout: Sequence[Log], rules: Rules = RULES) -> Split:
    """Held-out logs are those named, else the last of several, else the last third of the only one.

    Raises LogError.
    """
    if heldout:
        return Split(list(logs), list(heldout), (0.0,) * len(heldout))
    if len(logs) > 1:
        return Split(list(logs[:-1]), [logs[-1]], (0.0,))
    log = logs[0]
    number = int(rules.extension.fitted * len(log))
    if number < 2:
        raise LogError(f"{log.source}: {len(log)} samples are too few to hold some of them out")
    first = replace(log, frame=log.frame.iloc[:number].reset_index(drop=True))
    return Split([first], [log], (number * log.period,))
