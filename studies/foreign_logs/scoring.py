"""Counts answers against truths, a table per method."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from statsmodels.stats.proportion import proportion_confint

from pyident.regression.descriptions import describes
from pyident.sweep.studies import row

from .cases import Case
from .generator import Truth
from .methods import Answer, Name

OURS = "diagnosis"
_NONE = "no cases"


@dataclass(frozen=True)
class Scored:
    """One case, opened.  answers: method -> what it said;  failure: why there is none.

    besides   names that are right, too: of a delay, a gain, a small error of the geometry
    """

    kind: str
    difficult: bool
    truth: tuple[Truth, ...]
    answers: dict[str, Answer]
    failure: str = ""
    besides: tuple[Name, ...] = ()

    def said(self, method: str) -> Answer:
        """A case that failed, or that a method did not do, counts as a wrong answer."""
        return self.answers.get(method, Answer("failed", []))


def reopened(case: Case, answers: Mapping[str, Any], failure: str, sealed: Mapping[str, Any]) -> Scored:
    """A case as JSON kept it: what was said, method by method, and what was sealed."""
    said = {
        name: Answer(
            a["verdict"],
            [[(e, k) for e, k in tie] for tie in a["ties"]],
            a["amounts"],
            a.get("strengths", ()),
        )
        for name, a in answers.items()
    }
    truth = tuple(
        Truth(t["law"], tuple((e, k) for e, k in t["names"]), t["size"], t["amount"]) for t in sealed["truth"]
    )
    besides = tuple((e, k) for e, k in sealed["besides"])
    return Scored(case.kind, case.difficult, truth, said, failure, besides)


def of_diagnosis(cases: Sequence[Case], opened: Sequence[Mapping[str, Any]]) -> list[Scored]:
    """Cases to which the diagnosis alone answered, each with its file."""
    pairs = zip(cases, opened, strict=True)
    return [reopened(case, {OURS: file["said"]}, file["failure"], file) for case, file in pairs]


def table(cases: Sequence[Scored], methods: Sequence[str]) -> list[dict[str, str]]:
    """The diagnosis with its goals, then the other methods without: as they are, and as careful as it."""
    rows = []
    for method in methods:
        rows += _rows(cases, method, "" if method == OURS else f"{method}: ")
    for method in methods:
        if any(c.said(method).strengths for c in cases):
            rows += _rows(_as_careful(cases, method), method, f"{method}, wrong as seldom: ")
    rows = [r for r in rows if r["goal"] or r["value"] != _NONE]  # of other methods what there are cases of
    failed = sum(bool(c.failure) for c in cases)
    return [*rows, row("cases that failed", f"{failed} of {len(cases)}", "0", not failed)]


def _rows(cases: Sequence[Scored], method: str, prefix: str) -> list[dict[str, str]]:
    said = [(c, c.said(method)) for c in cases]

    def of(*kinds: str, difficult: bool | None = None) -> list[tuple[Scored, Answer]]:
        return [(c, a) for c, a in said if c.kind in kinds and difficult in (None, c.difficult)]

    def share(what: str, hits: list[bool], goal: float | None = None, most: bool = False) -> dict[str, str]:
        return counted(prefix + what, hits, goal if not prefix else None, most)

    def alarms(difficult: bool) -> list[bool]:
        return [is_alarm(c, a) for c, a in of("null", difficult=difficult)]

    strong, geometry, everything = of("strong"), of("geometry"), of("strong", "medium", "weak")
    three = [(sum(is_found(t, a) for t in c.truth), len(c.truth)) for c, a in of("triple")]
    return [
        share("false alarm, ordinary", alarms(False), 5, most=True),
        share("false alarm, difficult", alarms(True), 10, most=True),
        share("strong: in the first tie", [_first(c, a) for c, a in strong], 95),
        share("strong: strictly first", [_strictly(c, a) for c, a in strong], 90),
        share("medium found", [is_found(c.truth[0], a) for c, a in of("medium")], 80),
        share("weak found", [is_found(c.truth[0], a) for c, a in of("weak")], 30),
        share("single: confidently wrong", [is_wrong(c, a) for c, a in everything], 5, most=True),
        share("two at once: both", [all(is_found(t, a) for t in c.truth) for c, a in of("pair")], 70),
        share("three at once: all", [k == n for k, n in three], 60),
        share("three at once: at least two", [k >= 2 for k, _ in three], 90),
        share("geometry: named, value within 20 %", [_measured(c, a) for c, a in geometry], 90),
        share("geometry: in the first tie, value within 20 %", [_measured(c, a, True) for c, a in geometry]),
        share("outside: unexplained or a fair alias", [_honest(c, a) for c, a in of("outside")], 85),
        share("outside: confidently wrong", [is_wrong(c, a) for c, a in of("outside")], 5, most=True),
        share("of all findings with one name: right", findings_right(said, lambda tie: len(tie) == 1)),
        share(
            "of all findings in a tie: the truth among them", findings_right(said, lambda tie: len(tie) > 1)
        ),
        share(
            "of all findings of the robot file: right", findings_right(said, lambda tie: describes(tie[0][0]))
        ),
    ]


def _as_careful(cases: Sequence[Scored], method: str) -> list[Scored]:
    """The cases with what a method says where it names only what is strong enough.

    As strong as it takes on these very cases to be wrong in no more of them than the diagnosis is, or to name
    nothing; no stronger.
    """
    strengths = sorted({0.0, *(s for c in cases for s in c.said(method).strengths)})
    allowed = sum(_misleads(c, c.said(OURS)) for c in cases)

    def said(least: float) -> list[Scored]:
        return [replace(c, answers={method: _above(c.said(method), least)}) for c in cases]

    asked = (said(least) for least in strengths)
    careful = (of for of in asked if sum(_misleads(c, c.said(method)) for c in of) <= allowed)
    return next(careful, said(strengths[-1]))


def _misleads(case: Scored, answer: Answer) -> bool:
    """With nothing hidden an alarm, else a name that is wrong."""
    return is_alarm(case, answer) if case.kind == "null" else is_wrong(case, answer)


def _above(answer: Answer, least: float) -> Answer:
    """The findings that are stronger; a method that failed has failed."""
    ties = answer.ties[: sum(s > least for s in answer.strengths)]
    quiet = "nothing_detectable" if not ties and answer.verdict != "failed" else answer.verdict
    return replace(answer, verdict=quiet, ties=ties)


def right(truth: Sequence[Truth]) -> set[Name]:
    """Every name that is not wrong."""
    return {name for t in truth for name in t.names}


def is_alarm(case: Scored, answer: Answer) -> bool:
    """Anything at all with nothing hidden, but for what makes the case difficult."""
    quiet = answer.verdict == "nothing_detectable" or bool(answer.ties)
    return not quiet or is_wrong(case, answer)


def is_found(truth: Truth, answer: Answer) -> bool:
    return any(name in truth.names for tie in answer.ties for name in tie)


def _first(case: Scored, answer: Answer) -> bool:
    return bool(answer.ties) and bool(right(case.truth) & set(answer.ties[0]))


def _strictly(case: Scored, answer: Answer) -> bool:
    return bool(answer.ties) and answer.ties[0][0] in right(case.truth)


def is_wrong(case: Scored, answer: Answer) -> bool:
    """A finding none of whose names is right, or no answer at all."""
    names = right(case.truth) | set(case.besides)
    return answer.verdict == "failed" or any(not names & set(tie) for tie in answer.ties)


def findings_right(said: Sequence[tuple[Scored, Answer]], of: Callable[[Sequence[Name]], bool]) -> list[bool]:
    """Of every finding of one kind whether any of its names is true."""
    return [bool((right(c.truth) | set(c.besides)) & set(tie)) for c, a in said for tie in a.ties if of(tie)]


def _measured(case: Scored, answer: Answer, tied: bool = False) -> bool:
    """The true error with its value, first or (tied) anywhere among what these logs cannot tell apart."""
    true = case.truth[0].amount
    if true is None or not answer.ties:
        return False
    told = list(zip(answer.ties[0], answer.amounts, strict=False))[: None if tied else 1]
    own = [amount for name, amount in told if name in right(case.truth)]
    return any(amount is not None and abs(amount - true) <= 0.2 * abs(true) for amount in own)


def _honest(case: Scored, answer: Answer) -> bool:
    return answer.verdict not in ("failed", "nothing_detectable") and not is_wrong(case, answer)


def counted(what: str, hits: Sequence[bool], goal: float | None = None, most: bool = False) -> dict[str, str]:
    """goal [percent]; Wilson's 95 % interval."""
    wanted = "" if goal is None else f"{'<=' if most else '>='} {goal:g} %"
    if not hits:
        return row(what, _NONE, wanted)
    count, n = sum(hits), len(hits)
    low, high = proportion_confint(count, n, method="wilson")
    met = None if goal is None else (100 * count <= goal * n) if most else (100 * count >= goal * n)
    return row(what, f"{count} of {n} (95 %: {100 * low:.0f} to {100 * high:.0f} %)", wanted, met)
