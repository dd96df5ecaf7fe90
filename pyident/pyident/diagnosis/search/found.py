"""What one ranking of a search finds: candidates at their best values, and which cannot be told apart."""

from collections.abc import Iterable
from dataclasses import dataclass

from pyident.diagnosis.base.candidates import Candidate
from pyident.diagnosis.base.projection import Gain


@dataclass(frozen=True)
class Found:
    """A candidate at its best nonlinear values. pretended, spread: of its family's gain in replicas."""

    candidate: Candidate
    gain: Gain
    pretended: float
    spread: float

    @property
    def excess(self) -> float:
        return self.gain.energy - self.pretended

    @property
    def z(self) -> float:
        """Score: how many spreads it takes more than replicas pretend."""
        return self.excess / self.spread

    @property
    def freedom(self) -> int:
        """Number of parameters: of laws that explain alike, the one with fewer comes first."""
        return len(self.gain.coefficients) + len(self.candidate.nonlinear)

    def other_form_of(self, other: "Found") -> bool:
        """Whether both are one law at one joint, one of them with a size of its own at every speed."""
        a, b = self.candidate.family, other.candidate.family
        return a[:3] == b[:3] and a != b


@dataclass(frozen=True)
class Step:
    """One ranking of all families.

    tie     the best, and what cannot be told from it; begins `ranked`
    orders  further orders of the best one's law, if it is periodic: a ripple seldom has one
    """

    tie: tuple[Found, ...]
    p_value: float
    others: tuple[Found, ...]
    orders: tuple[Candidate, ...] = ()

    @property
    def best(self) -> Found:
        return self.tie[0]

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """What a model takes in with this step."""
        return self.best.candidate, *self.orders

    @property
    def ranked(self) -> tuple[Found, ...]:
        return self.tie + self.others


def others_than(step: Step, steps: Iterable[Step]) -> list[Candidate]:
    """What a model takes in with all steps but one."""
    return candidates_of(other for other in steps if other is not step)


def candidates_of(steps: Iterable[Step]) -> list[Candidate]:
    """What a model takes in with several steps, in their order."""
    return [c for step in steps for c in step.candidates]
