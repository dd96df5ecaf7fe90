"""What the diagnosis would say if each threshold of its search were half or twice what it is.

The cases are those of `rigid_arm`, of a seed that served for nothing else. Of each case the replicas are made
once; for every threshold and factor the search alone is run again.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from pyident.diagnosis.diagnose import concluded
from pyident.diagnosis.search.search import Search, search_of
from pyident.diagnosis.searched import searched
from pyident.rules.rule import RulesError
from pyident.rules.rules import RULES, Rules
from pyident.rules.search import SearchRules
from pyident.sweep.studies import StudyResult, row

from ..half_and_twice.answers import answers, reported
from ..rigid_arm.arm import arm
from ..rigid_arm.generator import Case, case_list, logs_of

SEED, NULLS = 6007, 3
FACTORS = (0.5, 2.0)
_AS_IT_IS = "as it is"


@dataclass(frozen=True)
class Scores:
    """Of how many cases of a kind the answer was right, and how many findings were wrong."""

    cleared: int
    first: int
    tied: int
    further: int
    outside: int

    def __str__(self) -> str:
        return (
            f"{self.cleared} nulls cleared, {self.first} first, {self.tied} in the first tie, "
            f"{self.further} further findings, {self.outside} outside named"
        )


def run(
    folder: Path, progress: Callable[[float], None], seed: int = SEED, nulls: int = NULLS, most: int = 100
) -> StudyResult:
    """A line per threshold. most: cases. A second call with the same folder goes on with what it lacks."""
    cases = case_list(seed, nulls)[:most]
    found = answers({f"{seed}_{case.id}": case for case in cases}, _said, folder, progress)
    said = {case.id: found[f"{seed}_{case.id}"] for case in cases}
    usual = scores(cases, {i: each[_AS_IT_IS] for i, each in said.items()})
    as_they_are = row(f"as they are, {len(cases)} cases", str(usual))
    return reported(folder / "thresholds.csv", as_they_are, _lines(cases, said, usual))


def variants() -> Iterator[tuple[str, Rules | None]]:
    """The rules as they are, and with one threshold of the search changed; None: they would contradict."""
    yield _AS_IT_IS, RULES
    for field in fields(SearchRules):
        value = getattr(RULES.search, field.name)
        for factor in FACTORS:
            yield f"{field.name} {factor:g}", _with(field.name, _scaled(value, factor))


def scores(cases: list[Case], answers: dict[str, dict[str, Any]]) -> Scores:
    """answers: case -> verdict and ties, each a list of effect and joint."""
    truth = {c.id: [c.law, f"joint{c.joint}"] for c in cases}
    singles = [(answers[c.id]["ties"], truth[c.id]) for c in cases if c.kind == "single"]
    return Scores(
        cleared=sum(answers[c.id]["verdict"] == "nothing_detectable" for c in cases if c.kind == "null"),
        first=sum(bool(ties) and ties[0][0] == true for ties, true in singles),
        tied=sum(bool(ties) and true in ties[0] for ties, true in singles),
        further=sum(true not in tie for ties, true in singles for tie in ties),
        outside=sum(bool(answers[c.id]["ties"]) for c in cases if c.kind == "outside"),
    )


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, tuple):
        return tuple(min(1.0, factor * x) for x in value)
    return max(1, round(factor * value)) if isinstance(value, int) else factor * value


def _with(name: str, value: Any) -> Rules | None:
    try:
        return replace(RULES, search=replace(RULES.search, **{name: value}))
    except RulesError:
        return None


def _said(case: Case) -> dict[str, Any]:
    """Of a case under every variant."""
    logs = logs_of(case)
    search = searched(arm(), logs[:-1], _never)
    said = {}
    for name, rules in variants():
        if rules is not None:
            found = concluded(_under(search, rules), _never, logs[-1:])
            ties = [[(n.effect, n.joint) for n in f.tie] for f in found.findings]
            said[name] = {"verdict": found.verdict, "ties": ties}
    return said


def _under(search: Search, rules: Rules) -> Search:
    """The search of the same examination by other rules."""
    examination = search.examination
    return search_of(replace(examination, setting=replace(examination.setting, rules=rules)))


def _never(_: Any) -> Any:
    raise AssertionError("along the measured motion nothing is simulated")


def _lines(cases: list[Case], said: dict[str, Any], usual: Scores) -> Iterator[dict[str, str]]:
    for field in fields(SearchRules):
        changed = {}
        for factor, word in zip(FACTORS, ("half", "twice"), strict=True):
            name = f"{field.name} {factor:g}"
            known = all(name in each for each in said.values())
            found = scores(cases, {i: each[name] for i, each in said.items()}) if known else None
            changed[word] = "refused" if found is None else _difference(usual, found)
        yield {"threshold": field.name, "value": str(getattr(RULES.search, field.name)), **changed}


def _difference(usual: Scores, found: Scores) -> str:
    """Each score that changed, from and to."""
    pairs = ((f.name, getattr(usual, f.name), getattr(found, f.name)) for f in fields(Scores))
    return ", ".join(f"{name} {a} to {b}" for name, a, b in pairs if a != b) or "the same"
