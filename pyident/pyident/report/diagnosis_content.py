"""The tables of a diagnosis' page, as plain values in reading order."""

from collections.abc import Sequence
from dataclasses import dataclass

from pyident.diagnosis.result import Diagnosis, Finding, Limit, Named, Row
from pyident.report.diagnosis_figures import band_name, colour, row_name
from pyident.report.wording import measured, number, unit

_NEIGHBOURS = 4  # rivals that are argued with, per finding
_WORTH = 1.0  # % that a rival must take away by itself to be argued with
_SIDES = {"motor": "motor", "transmission": "drive", "link": "link"}


@dataclass(frozen=True)
class Told:
    """A finding with its rivals: effects that it leaves nothing to do."""

    finding: Finding
    name: str
    rivals: tuple[Named, ...]


@dataclass(frozen=True)
class Side:
    """One side of a joint in the drawing: how far over the floor, its colour, whether it is the place."""

    name: str
    over_floor: float
    colour: str
    here: bool


@dataclass(frozen=True)
class Worst:
    """Where the residual stands highest over the floor."""

    row: str
    band: str
    over_floor: float
    rms: str


@dataclass(frozen=True)
class ParameterRow:
    """A parameter as the page shows it, or that it is not known."""

    name: str
    value: str
    unit: str


def findings(d: Diagnosis) -> list[Told]:
    """In the order of acceptance."""
    mine = {(n.effect, n.joint) for f in d.findings for n in f.tie}
    others = [n for n in d.ranking if (n.effect, n.joint) not in mine]
    return [Told(f, " or ".join(_name(n) for n in f.tie), _rivals(f.tie[0], others)) for f in d.findings]


def ranking(d: Diagnosis) -> list[tuple[Named, bool]]:
    """Every effect that takes something away by itself, best first, and whether it is among the findings."""
    mine = {(n.effect, n.joint, n.log) for f in d.findings for n in f.tie}
    best = sorted(d.ranking, key=lambda n: -n.gain_percent)
    return [(n, (n.effect, n.joint, n.log) in mine) for n in best if n.gain_percent > 0]


def parameters(d: Diagnosis) -> list[tuple[Named, list[ParameterRow]]]:
    """Of every member of every tie."""
    return [(n, [_row(n, name) for name in n.values]) for f in d.findings for n in f.tie]


def _row(n: Named, name: str) -> ParameterRow:
    value, std = n.values[name], n.std[name]
    known = measured(value, std) if n.determines(name) else "not determined by itself"
    return ParameterRow(name, known, unit(n.units[name]))


def found_twice(d: Diagnosis) -> list[Named]:
    """Best candidates that were accepted again with other nonlinear values."""
    best = [f.tie[0] for f in d.findings]
    return [n for i, n in enumerate(best) if (n.effect, n.joint) in [(m.effect, m.joint) for m in best[:i]]]


def left_for(d: Diagnosis) -> tuple[Named, float] | None:
    """The effect that takes most of what the findings leave, and its share of that [%]; None: not asked."""
    asked = [(n.beside_percent, n) for n in d.ranking if n.beside_percent is not None]
    if not asked or d.remaining <= 1:
        return None
    share, best = max(asked, key=lambda pair: pair[0])
    return best, min(share * (d.excess - 1) / (d.remaining - 1), 100.0)


def joints(rows: Sequence[Row], place: tuple[str, str] | None) -> list[tuple[str, list[Side]]]:
    """Every joint with its sides, each at its worst row and band."""
    over: dict[str, dict[str, float]] = {}
    for row in rows:
        sides = over.setdefault(row.joint, {})
        sides[row.balance] = max(sides.get(row.balance, 0.0), *row.over_floor)
    top = max((v for sides in over.values() for v in sides.values()), default=1.0)
    return [
        (joint, [Side(_SIDES[b], v, colour(v, top), (joint, b) == place) for b, v in sides.items()])
        for joint, sides in over.items()
    ]


def worst_place(rows: Sequence[Row]) -> Worst | None:
    """The row and band that stand highest; None without rows."""
    if not rows:
        return None
    row = max(rows, key=lambda r: max(r.over_floor))
    at = max(range(len(row.bands)), key=lambda b: row.over_floor[b])
    return Worst(row_name(row), band_name(row.bands[at]), row.over_floor[at], number(row.rms[at]))


def limit_table(limits: Sequence[Limit]) -> tuple[list[str], list[tuple[str, list[Limit | None]]]]:
    """The joints, and per effect its limit at each of them."""
    names = list(dict.fromkeys(x.joint for x in limits))
    by_effect: dict[str, dict[str, Limit]] = {}
    for x in limits:
        by_effect.setdefault(x.effect, {})[x.joint] = x
    return names, [(effect, [at.get(joint) for joint in names]) for effect, at in by_effect.items()]


def _rivals(best: Named, others: Sequence[Named]) -> tuple[Named, ...]:
    """What takes something away at the same joint, but by half less beside the findings: it imitated them."""
    alike = [n for n in others if n.joint == best.joint and n.gain_percent >= _WORTH]
    worth = [n for n in alike if n.beside_percent is None or n.beside_percent < n.gain_percent / 2]
    return tuple(sorted(worth, key=lambda n: -n.gain_percent)[:_NEIGHBOURS])


def _name(n: Named) -> str:
    """With the nonlinear values, which tell apart two of a kind."""
    fixed = [f"{name} {number(n.values[name])} {unit(n.units[name])}".strip() for name in n.nonlinear]
    return f"{n.effect} at {n.joint}" + (f" ({', '.join(fixed)})" if fixed else "")
