"""Every threshold by which logs are compared and effects are named."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import ceil

import pandas as pd

from pyident.rules.bins import BINS
from pyident.rules.channel_checks import CHANNELS
from pyident.rules.comparison import ComparisonRules
from pyident.rules.equation_checks import EQUATIONS
from pyident.rules.greybox import GREYBOX
from pyident.rules.log_checks import CHANGES, LOG_CHECKS
from pyident.rules.periodic import PeriodicRules
from pyident.rules.replicas import ReplicaRules
from pyident.rules.rule import Line, RulesError, lines
from pyident.rules.search import SearchRules
from pyident.rules.stillness import STILLNESS
from pyident.rules.unexplained import ExtensionRules, UnexplainedRules


@dataclass(frozen=True)
class Rules:
    """All groups. Another value is given by `dataclasses.replace`; raises RulesError where it cannot work."""

    comparison: ComparisonRules = field(default_factory=ComparisonRules)
    replicas: ReplicaRules = field(default_factory=ReplicaRules)
    search: SearchRules = field(default_factory=SearchRules)
    periodic: PeriodicRules = field(default_factory=PeriodicRules)
    unexplained: UnexplainedRules = field(default_factory=UnexplainedRules)
    extension: ExtensionRules = field(default_factory=ExtensionRules)

    def __post_init__(self) -> None:
        needed = ceil(1 / self.search.level - 1e-9) - 1
        if self.replicas.count < needed:
            raise RulesError(
                f"rules: {self.replicas.count} replicas cannot show a chance below "
                f"{100 / (1 + self.replicas.count):.3g} %, so nothing would ever be named at a level of "
                f"{100 * self.search.level:.3g} %; take {needed} replicas or more, or a higher level"
            )

    def to_frame(self) -> pd.DataFrame:
        """name, value, of, why, fixed_on: a line per threshold."""
        return pd.DataFrame([vars(line) for line in lines(self)]).set_index("name")


RULES = Rules()


def every_threshold() -> Iterator[Line]:
    """Those of `RULES`, and those that no caller changes: of checks, bins, foreign FMUs and standstill."""
    yield from lines(RULES)
    beside = {
        "log_checks": LOG_CHECKS,
        "channel_checks": CHANNELS,
        "change_checks": CHANGES,
        "equation_checks": EQUATIONS,
        "bins": BINS,
        "greybox": GREYBOX,
        "stillness": STILLNESS,
    }
    for name, group in beside.items():
        yield from lines(group, f"{name}.")
