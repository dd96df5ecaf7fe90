"""How many grossly wrong logs are flagged, and how many good ones: the test bench of the checks."""

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pandas as pd
from pyident.sweep.studies.log_checks import (  # their kinds register themselves  # pyright: ignore[reportMissingImports]
    wrong_channels,  # noqa: F401
    wrong_rows,  # noqa: F401
)
from pyident.sweep.studies.log_checks.good_logs import Case, foreign, good_logs  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.log_checks.rigid_arm import Motion, recorded, six_axes  # pyright: ignore[reportMissingImports]
from pyident.sweep.studies.log_checks.wrong_logs import KINDS  # pyright: ignore[reportMissingImports]

from flexmodels.robot import Robot
from pyident.checks.check_log import check_log
from pyident.checks.defect import Defect
from pyident.logs.log import Log, LogError, check
from pyident.sweep.studies import StudyResult, row

SHARE = 95.0  # [%] of the wrong logs that must be flagged


def run(folder: Path, progress: Callable[[float], None]) -> StudyResult:
    """Every kind on every robot, every good log; the tables go to `folder`."""
    bases = list(sound_bases())
    wrong = pd.DataFrame(list(_tried(bases, lambda share: progress(0.7 * share))))
    good = pd.DataFrame([_judged(name, robot, log) for name, robot, log in _seen(good_logs(), progress)])
    wrong.to_csv(folder / "wrong.csv", index=False)
    good.to_csv(folder / "good.csv", index=False)
    (folder / "table.md").write_text(table(wrong, good), encoding="utf-8")
    share = 100 * (wrong["outcome"] != "missed").mean()
    refused = 100 * (wrong["outcome"] == "refused").mean()
    false = int((good["outcome"] != "missed").sum())  # pyright: ignore[reportArgumentType]
    kinds = wrong["case"].nunique()
    return StudyResult(
        [
            row(f"wrong logs flagged ({kinds} kinds, {len(wrong)} logs of {len(bases)} robots)",
                f"{share:.1f} %", f"≥ {SHARE:g} %", share >= SHARE),  # pyright: ignore[reportArgumentType]
            row("of these refused", f"{refused:.1f} %"),
            row(f"good logs flagged (of {len(good)})", str(false), "0", false == 0),
        ],
        [folder / "wrong.csv", folder / "good.csv", folder / "table.md"],
        [f"missed: {r.case} ({r.robot})" for r in wrong.itertuples() if r.outcome == "missed"]  # pyright: ignore[reportAttributeAccessIssue]
        + [f"false alarm: {r.case}: {r.sentence}" for r in good.itertuples() if r.outcome != "missed"],  # pyright: ignore[reportAttributeAccessIssue]
    )  # fmt: skip


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
        check(frame, source)
        defects = check_log(robot, Log(frame, source))
    except LogError as error:
        return "refused", str(error)
    if any(defect.severity == "gross" for defect in defects):
        return "refused", defects
    return ("warned" if defects else "missed"), defects


def _tried(bases: list[tuple[Robot, Log]], progress: Callable[[float], None]) -> Iterator[dict[str, str]]:
    for i, (name, change) in enumerate(KINDS.items()):
        progress(i / len(KINDS))
        for robot, log in bases:
            frame = change(robot, log.frame.copy())
            if frame is not None:
                yield _row(name, robot, *outcome(robot, frame, "log.csv"))


def _judged(name: str, robot: Robot, log: Log) -> dict[str, str]:
    return _row(name, robot, *outcome(robot, log.frame, log.source))


def _row(name: str, robot: Robot, what: str, why: tuple[Defect, ...] | str) -> dict[str, str]:
    said = why if isinstance(why, str) else " | ".join(f"[{d.kind}] {d.sentence}" for d in why)
    return {"case": name, "robot": robot.name, "outcome": what, "sentence": said}


def _seen(cases: Iterator[Case], progress: Callable[[float], None]) -> Iterator[Case]:
    for i, case in enumerate(cases):
        progress(min(0.7 + 0.005 * i, 1.0))
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
