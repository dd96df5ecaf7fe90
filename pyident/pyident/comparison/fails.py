"""Where a model fails most, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

from flexmodels.coordinate import is_motor, is_torque, joint_number
from pyident.comparison.bins import Bin
from pyident.comparison.errors import Error, LogErrors
from pyident.comparison.trial import Trial

_AT_FLOOR = 1.05  # times the floor: what is less reads as one
_HIDES = 20.0  # % of a signal that a floor reaches: less than it tells little then
_STAND_IN = "; how closely is the doing of the loop that stands in for a controller, so judge by the torques"


@dataclass(frozen=True)
class Fails:
    """The parts that stand out most under the model's own parameters (values) and under refitted ones
    (structure); None: nothing does.

    doubted   what would, but for slow noise, which may do as much
    slow      times what such noise leaves that values leave, where it may be all that no values mend
    """

    values: Bin | None
    structure: Bin | None
    doubted: Bin | None = None
    slow: float | None = None

    @property
    def structural(self) -> bool:
        """Whether what no other values mend stands out most."""
        return self.structure is not None and not self._elsewhere

    @property
    def where(self) -> Bin | None:
        return self.structure if self.structural else self.values

    @property
    def _elsewhere(self) -> bool:
        """Whether values fail more, of another equation."""
        values, structure = self.values, self.structure
        if values is None or structure is None or values.coordinate == structure.coordinate:
            return False
        return values.ratio > structure.ratio

    def beside(self, slow: "Fails") -> "Fails":
        """What is certain of it. slow: the same beside replicas with as much slow noise as there may be."""
        if slow.where is None:
            return Fails(None, None, self.where)
        if slow.structure is not None:
            return self
        rest = slow.values.ratio if slow.values is not None and self.structure is not None else None
        return Fails(self.values or slow.values, None, slow=rest)

    def sentence(self, tracks: bool) -> str:
        """tracks: whether values that are fitted to these logs by themselves make simulations track them."""
        if self.where is None and self.doubted is not None:
            most = f"{_place(self.doubted)}: {self.doubted.ratio:.2g} times the floor"
            return (
                f"Nothing stands out for certain; most is left at {most}, which slow noise may do as well. "
                "`pyident diagnose` asks whether a law explains it."
            )
        if self.where is None:
            return "Nothing stands out: the equations leave what the method itself leaves."
        most = f"most at {_place(self.where)}: {self.where.ratio:.2g} times the floor"
        if self.structural:
            return f"It fails {most}. `pyident diagnose` asks what it lacks."
        left, slow = self.structure, self.slow
        rest = "" if left is None else f" What these leave is most at {_place(left)}: {left.ratio:.2g} times."
        how = "on these logs" if tracks else "with --refine"
        noise = "" if slow is None else f" ({slow:.2g} times that of slow noise, if these logs have any)"
        return (
            f"The values of its parameters are off, {most}{noise}, and other values take that away: identify "
            f"it {how}. If it was identified on this robot before, other values only make up for what is "
            f"missing, which `pyident diagnose` asks of all logs together.{rest}"
        )


def _place(where: Bin) -> str:
    place = f"joint {joint_number(where.coordinate)}, {where.balance} side"
    return f"{place}, {where.label}" if where.label else place


def in_simulation(trial: Trial, errors: Sequence[LogErrors], calm: bool = False) -> str:
    """By how much simulations miss, in words. calm: whether nothing stands out of the equations."""
    kinds = (is_torque,) if trial.tracks else ("tip".__eq__, is_motor)
    missed = [(e.simulation[n], n) for told in kinds for e in errors for n in e.simulation if told(n)]
    name = missed[0][1] if missed[0][1] == "tip" else max(missed, key=lambda pair: pair[0].ratio)[1]
    error = max((e for e, n in missed if n == name), key=lambda e: e.ratio)
    what = "the tip" if name == "tip" else f"joint {joint_number(name)}"
    what += "'s torque" if trial.tracks else ""
    by = f"{error.rmse:.3g} {error.unit} rms, {_over(error)}"
    note = next((r.note for r in trial.judged if r.note), None)
    why = f" The simulation follows the measured motion ({note}){_STAND_IN}." if note else ""
    if calm and error.ratio >= _AT_FLOOR:
        return f"But in simulation, where small errors of values add up, {what} misses by {by}.{why}"
    return f"In simulation {what} misses by {by}.{why}"


def _over(error: Error) -> str:
    """An error beside its floor, and whether that tells anything."""
    if error.ratio >= _AT_FLOOR:
        return f"{error.ratio:.2g} times the floor"
    high = f", which hides much: {error.floor_percent:.2g} % of it" if error.floor_percent > _HIDES else ""
    return f"no more than the floor{high}"
