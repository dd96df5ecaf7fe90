"""What is wrong with a log: a value, so that every command, page and machine can carry it."""

from dataclasses import asdict, dataclass
from typing import Literal

Severity = Literal["gross", "doubtful"]


@dataclass(frozen=True)
class Defect:
    """One defect of a log.

    severity   gross: nothing that is fitted to the log can be believed; doubtful: it should be looked at
    kind       a word for machines: `stuck`, `sign`, `unit`, `delay`, `order` ...
    channel    the signal, empty where it is the log as a whole
    sentence   what, where and how to mend it, beginning with the log's name
    another_body   the log, and the time [s] from which its last link has another body; None: no such defect
    """

    severity: Severity
    kind: str
    channel: str
    sentence: str
    another_body: tuple[str, float] | None = None

    @property
    def delays_all(self) -> bool:
        """Whether it is a delay of all torques alike."""
        return (self.kind, self.channel) == ("delay", "")

    def json(self) -> dict[str, str]:
        return {name: value for name, value in asdict(self).items() if name != "another_body"}
