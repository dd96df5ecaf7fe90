"""Opens the seals and counts."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from pyident.sweep.studies import row

from .oracle import Name

NAMING = ("missing_effect", "cannot_tell")
FAILED = "failed"


@dataclass(frozen=True)
class Scored:
    """One case with its truth and what was said about it.

    ties         of the findings, in their order, the best name first
    reached      share that what was found takes of what exceeds the floor on held-out data, on the
                 equations of the true effects [%]; `achievable`: that the truth takes
    aliases      names that would do exactly the same as one of the true ones in these logs
    """

    id: str
    kind: str
    truth: tuple[Name, ...]
    verdict: str
    ties: tuple[tuple[Name, ...], ...] = ()
    reached: float | None = None
    achievable: float | None = None
    aliases: tuple[Name, ...] = ()
    seconds: float = float("nan")
    failure: str = ""

    @property
    def first_tie(self) -> tuple[Name, ...]:
        return self.ties[0] if self.ties else ()

    @property
    def named(self) -> set[Name]:
        return {name for tie in self.ties for name in tie}

    @property
    def share(self) -> float | None:
        """Of the achievable fall; None where the truth itself makes none."""
        if self.reached is None or self.achievable is None or self.achievable <= 0:
            return None
        return self.reached / self.achievable


def unseal(folder: Path, name: str) -> Scored:
    """One case of a folder. A case that failed is scored as a wrong answer."""
    key = _read(folder / "sealed" / name / "key.json")
    said = _read(folder / "diagnosed" / f"{name}.json")
    truth = tuple((law["law"], int(law["joint"])) for law in key.get("laws", ()))
    if "diagnosis" not in said:
        reason = said.get("failure", "its process ended")
        return Scored(name, key.get("kind", "unknown"), truth, FAILED, failure=reason)
    best = _read(folder / "sealed" / name / "oracle.json")
    return Scored(
        name,
        key["kind"],
        truth,
        said["diagnosis"]["verdict"],
        tuple(_names(finding["tie"]) for finding in said["diagnosis"]["findings"]),
        best.get("reached_percent"),
        best.get("achievable_percent"),
        tuple((effect, joint) for names in best.get("aliases", ()) for effect, joint in names),
        said["seconds"],
    )


def _read(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def _names(tie: Sequence[dict[str, str]]) -> tuple[Name, ...]:
    """Each name once: a payload may be there for several logs."""
    return tuple(dict.fromkeys((n["effect"], int(n["joint"].removeprefix("joint"))) for n in tie))


def score(cases: Sequence[Scored]) -> list[dict[str, str]]:
    """The table; shares with Wilson's 95 % interval."""
    of = {
        kind: [c for c in cases if c.kind == kind]
        for kind in ("null", "single", "pair", "outside", "unobservable")
    }
    plain = [c for c in of["single"] if not c.aliases]
    return [
        share(
            "false alarm with nothing hidden", [c.verdict != "nothing_detectable" for c in of["null"]], most=5
        ),
        share("the truth is in the first tie", [c.truth[0] in c.first_tie for c in of["single"]], least=95),
        share(
            "the truth is strictly first, effects without exact alias",
            [c.first_tie[:1] == c.truth for c in plain],
            least=85,
        ),
        _tie_size(of["single"]),
        _fall([*of["single"], *of["pair"]]),
        share("pairs: both found", [set(c.truth) <= c.named for c in of["pair"]], least=70),
        share("pairs: at least one found", [bool(set(c.truth) & c.named) for c in of["pair"]], least=95),
        share(
            "outside the catalogue: unexplained",
            [c.verdict == "unexplained" for c in of["outside"]],
            least=80,
        ),
        share(
            "outside the catalogue: confidently wrong",
            [c.verdict in ("missing_effect", FAILED) for c in of["outside"]],
            most=10,
        ),
        share(
            "not observable: cannot tell, or nothing",
            [c.verdict in ("cannot_tell", "nothing_detectable") for c in of["unobservable"]],
            least=95,
        ),
        share(
            "single effects: the truth is in the first tie, and the verdict names it",
            [c.verdict in NAMING and c.truth[0] in c.first_tie for c in of["single"]],
        ),
        share(
            "single effects: a further finding without the truth",
            [any(c.truth[0] not in tie for tie in c.ties[1:]) for c in of["single"]],
        ),
        share("failed cases", [bool(c.failure) for c in cases], most=0),
    ]


def share(
    what: str, hits: Sequence[bool], least: float | None = None, most: float | None = None
) -> dict[str, str]:
    """least, most: the goal in percent."""
    goal = f">= {least:g} %" if least is not None else f"<= {most:g} %" if most is not None else ""
    if not hits:
        return row(what, "no cases", goal)
    n, count = len(hits), sum(hits)
    low, high = proportion_confint(count, n, method="wilson")
    percent = 100 * count / n
    text = f"{percent:.0f} % ({count} of {n}; 95 %: {100 * low:.0f} to {100 * high:.0f} %)"
    met = percent >= least if least is not None else percent <= most if most is not None else None
    return row(what, text, goal, met)


def _tie_size(cases: Sequence[Scored]) -> dict[str, str]:
    sizes = [len(c.first_tie) for c in cases if c.ties]
    what, goal = "mean size of the first tie", "<= 2"
    if not sizes:
        return row(what, "no findings", goal, None if not cases else False)
    text = f"{np.mean(sizes):.2f} (largest {max(sizes)}; {len(sizes)} of {len(cases)} cases have a finding)"
    return row(what, text, goal, bool(np.mean(sizes) <= 2))


def _fall(cases: Sequence[Scored]) -> dict[str, str]:
    shares = [0.0 if c.failure else c.share for c in cases]
    known = [s for s in shares if s is not None]
    what, goal = "share of the achievable fall of the held-out error, median", ">= 0.95"
    if not known:
        return row(what, "no cases", goal)
    text = f"{np.median(known):.3f} (lower quartile {np.quantile(known, 0.25):.3f}; {len(known)} cases)"
    return row(what, text, goal, bool(np.median(known) >= 0.95))


def table(cases: Sequence[Scored]) -> pd.DataFrame:
    """A line per case."""
    return pd.DataFrame(
        {
            "id": [c.id for c in cases],
            "kind": [c.kind for c in cases],
            "truth": [_joined(c.truth, " + ") for c in cases],
            "verdict": [c.verdict for c in cases],
            "names": [" + ".join(_joined(tie, " or ") for tie in c.ties) for c in cases],
            "share": [np.nan if c.share is None else c.share for c in cases],
            "reached_percent": [np.nan if c.reached is None else c.reached for c in cases],
            "achievable_percent": [np.nan if c.achievable is None else c.achievable for c in cases],
            "aliases": [_joined(c.aliases, " ") for c in cases],
            "seconds": [c.seconds for c in cases],
            "failure": [c.failure for c in cases],
        }
    )


def _joined(names: Sequence[Name], by: str) -> str:
    return by.join(f"{effect}@{joint}" for effect, joint in names)
