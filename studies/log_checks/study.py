"""How many grossly wrong logs are flagged, and how many good ones: the test bench of the checks."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from flexmodels.robot import Robot
from pyident.checks.check_log import check_log
from pyident.checks.defect import Defect
from pyident.logs.log import Log, LogError
from pyident.sweep.studies import StudyResult, row

from . import (  # their kinds register themselves
    wrong_channels,  # noqa: F401
    wrong_rows,  # noqa: F401
)
from .good_logs import Case, foreign, good_logs, scara, unseen
from .lacking import lacking
from .swings import Motion, recorded, six_axes
from .wrong_logs import KINDS

_AT_MOST = 80  # good logs of one origin
SHARE = 95.0  # [%] of the wrong logs that must be flagged


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Every kind on every robot, every good log; the tables go to `folder`.

    Thresholds were fixed on the first three robots' logs and the first good logs. One more motion of each
    rigid arm, and good logs of motions drawn at random, came when they stood, and only judge them.
    """
    bases, judges = list(sound_bases()), list(judging_bases())
    wrong = pd.DataFrame(list(_tried([*bases, *judges], len(bases), lambda share: progress(0.6 * share))))
    shares = ((0.6, 0.8), (0.8, 0.87), (0.87, 1.0))
    good, fresh, lawless = (
        pd.DataFrame([_judged(*case) for case in _seen(cases, progress, *share)])
        for cases, share in zip((good_logs(), unseen(), lacking()), shares, strict=True)
    )
    tables = {"wrong": wrong, "good": good, "unseen": fresh, "lacking": lawless}
    for name, table_of in tables.items():
        table_of.to_csv(folder / f"{name}.csv", index=False)
    (folder / "table.md").write_text(table(wrong, pd.concat([good, fresh, lawless])), encoding="utf-8")
    return StudyResult(
        [*_flagged(wrong.loc[wrong["fixed"]], "fixed on"), *_flagged(wrong.loc[~wrong["fixed"]], "judged by"),
         _alarms(good, "fixed on"), _alarms(fresh, "judged by"), *_of_lacking(lawless)],
        [*(folder / f"{name}.csv" for name in tables), folder / "table.md"],
        [*_missed(wrong), *_false(good), *_false(fresh), *_false(lawless)],
    )  # fmt: skip


def _missed(wrong: pd.DataFrame) -> list[str]:
    missed = wrong[wrong["outcome"] == "missed"]
    return [f"missed: {case} ({robot})" for case, robot in zip(missed["case"], missed["robot"], strict=True)]


def _false(good: pd.DataFrame) -> list[str]:
    flagged = good[good["outcome"] != "missed"]
    return [
        f"false alarm: {case}: {said}"
        for case, said in zip(flagged["case"], flagged["sentence"], strict=True)
    ]


def _flagged(wrong: pd.DataFrame, role: str) -> list[dict[str, str]]:
    outcomes = wrong["outcome"].to_numpy()
    share = 100 * float(np.mean(outcomes != "missed"))
    refused = 100 * float(np.mean(outcomes == "refused"))
    of = f"{wrong['case'].nunique()} kinds, {len(wrong)} logs of {wrong['robot'].nunique()} robots"
    return [
        row(f"wrong logs flagged ({role}: {of})", f"{share:.1f} %", f"≥ {SHARE:g} %", share >= SHARE),
        row("of these refused", f"{refused:.1f} %"),
    ]


def _alarms(good: pd.DataFrame, role: str) -> dict[str, str]:
    false = int((good["outcome"] != "missed").sum())  # pyright: ignore[reportArgumentType]
    return row(f"good logs flagged ({role}: {len(good)})", str(false), "0", false == 0)


def _of_lacking(cases: pd.DataFrame) -> Iterator[dict[str, str]]:
    """A strong law that a model lacks is no reason to refuse a log, nor to doubt its channels."""
    outcomes = cases["outcome"].to_numpy()
    refused = int(np.sum(outcomes == "refused"))
    yield row(
        f"logs of arms that lack a strong law: refused (of {len(cases)})", str(refused), "0", refused == 0
    )
    yield row("of these warned of", str(int(np.sum(outcomes == "warned"))))


def judging_bases() -> Iterator[tuple[Robot, Log]]:
    """A motion of each rigid arm that no threshold was fixed on."""
    for robot in (six_axes(), scara()):
        if robot is not None:
            named = replace(robot, name=f"{robot.name}, unseen")
            yield (
                named,
                Log(recorded(named, Motion(speed=0.8, highest=1.1, duration=14.0), 2077), "unseen.csv"),
            )


def sound_bases() -> Iterator[tuple[Robot, Log]]:
    """One sound log of each robot: two by other simulators, one by Pinocchio."""
    seen = set()
    for robot, log in foreign():
        if robot.name not in seen and "presliding" not in log.source:
            seen.add(robot.name)
            yield robot, log
    robot = six_axes()
    yield robot, Log(recorded(robot, Motion(), 7), "six_axes.csv")


def outcome(robot: Robot, frame: pd.DataFrame, source: str) -> tuple[str, tuple[Defect, ...] | str]:
    """refused, warned or missed; and why. A log that cannot even be read is refused."""
    try:
        defects = check_log(robot, Log(frame, source))
    except LogError as error:
        return "refused", str(error)
    if any(defect.severity == "gross" for defect in defects):
        return "refused", defects
    return ("warned" if defects else "missed"), defects


def _tried(
    bases: list[tuple[Robot, Log]], fixed: int, progress: Callable[[float], None]
) -> Iterator[dict[str, str | bool]]:
    """Every kind on every base; the rules were fixed on the first `fixed` of these."""
    for i, (name, change) in enumerate(KINDS.items()):
        progress(i / len(KINDS))
        for k, (robot, log) in enumerate(bases):
            frame = change(robot, log.frame.copy())
            if frame is not None:
                yield _row(name, robot, *outcome(robot, frame, "log.csv")) | {"fixed": k < fixed}


def _judged(name: str, robot: Robot, log: Log) -> dict[str, str]:
    return _row(name, robot, *outcome(robot, log.frame, log.source))


def _row(name: str, robot: Robot, what: str, why: tuple[Defect, ...] | str) -> dict[str, str]:
    said = why if isinstance(why, str) else " | ".join(f"[{d.kind}] {d.sentence}" for d in why)
    return {"case": name, "robot": robot.name, "outcome": what, "sentence": said}


def _seen(
    cases: Iterator[Case], progress: Callable[[float], None], start: float, end: float
) -> Iterator[Case]:
    for i, case in enumerate(cases):
        progress(min(start + (end - start) * i / _AT_MOST, end))
        yield case


def table(wrong: pd.DataFrame, good: pd.DataFrame) -> str:
    """Markdown: kinds by robot, then the good logs."""
    wide = (
        wrong.pivot(index="case", columns="robot", values="outcome")
        .reindex(wrong["case"].unique())
        .fillna("–")
    )
    lines = [
        "| what was done to a sound log | " + " | ".join(wide) + " |",
        "|---" * (len(wide.columns) + 1) + "|",
    ]
    lines += [f"| {name} | " + " | ".join(cells) + " |" for name, cells in wide.iterrows()]
    count = Counter(good["outcome"])
    lines += [
        "",
        f"Good logs: {len(good)}, of which {count['refused']} refused and {count['warned']} warned of:",
        "",
    ]
    for case, outcome in zip(good["case"], good["outcome"], strict=True):
        lines.append(f"- {case}" + ("" if outcome == "missed" else f" (**{outcome}**)"))
    return "\n".join(lines) + "\n"
