"""What `compare`, `diagnose` and `add_effect` return."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyident.diagnosis.verdict import separating
from pyident.verbs.result import Result
from pyident.verbs.terminal.table import table
from pyident.verbs.text import Text, wrapped

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from flexmodels.robot import Robot
    from pyident.comparison.compare import Comparison
    from pyident.diagnosis.result import Diagnosis
    from pyident.extension.add_effect import Extended
    from pyident.report.moving_arm import MovingArm

_SHOWN = 4  # names in a line


@dataclass(frozen=True, repr=False)
class Compared(Result):
    """Where a model fails on logs, and by how much compared with the method's own floor.

    arms   per log: the arm as it moved and as it was simulated, for a page
    """

    comparison: "Comparison"
    notes: tuple[str, ...]
    arms: "tuple[MovingArm, ...]" = ()

    def headline(self) -> str:
        return self.comparison.sentence

    def to_dict(self) -> dict[str, Any]:
        return self.comparison.json() | {"notes": list(self.notes)}

    def to_frame(self) -> "pd.DataFrame":
        """A row per log, kind and signal: rmse with its unit, that of the signal, and over the floor."""
        import pandas as pd

        rows = [
            (log.log, kind, name, e.rmse, e.unit, e.nrmse_percent, e.floor_percent, e.ratio)
            for log in self.comparison.logs
            for kind in ("equations", "simulation")
            for name, e in getattr(log, kind).items()
        ]
        heads = ["log", "kind", "signal", "rmse", "unit", "nrmse_percent", "floor_percent", "over_floor"]
        return pd.DataFrame(rows, columns=heads).set_index(["log", "kind", "signal"])

    def summary(self) -> Text:
        return side_by_side([self.comparison.robot], [self])

    def plot(self) -> "Figure":
        """Every signal's error over its floor, a panel per log."""
        from pyident.verbs.figures.plots import over_floor

        return over_floor(
            {log.log: [(name, e.ratio) for name, e in _told(log)] for log in self.comparison.logs}
        )

    def save(self, path: str | Path, model: str = "") -> Path:
        """Write the page (HTML)."""
        from pyident.report.comparison import write_comparison

        name = model or self.comparison.robot
        return write_comparison(Path(path), [name], [self.comparison], self.notes, self.arms)


@dataclass(frozen=True, repr=False)
class Diagnosed(Result):
    """Which effect a model lacks: names, names that cannot be told apart, none that is known, or nothing."""

    diagnosis: "Diagnosis"
    notes: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """nothing_detectable, missing_effect, unexplained or cannot_tell."""
        return self.diagnosis.verdict

    def headline(self) -> str:
        return self.diagnosis.sentence

    def to_dict(self) -> dict[str, Any]:
        return self.diagnosis.json() | {"notes": list(self.notes)}

    def to_frame(self) -> "pd.DataFrame":
        """A row per effect that a finding names."""
        import pandas as pd

        rows = [
            (i, n.effect, n.joint, f.p_value, f.share_percent, f.heldout_gain_percent, f.heldout_std_percent)
            for i, f in enumerate(self.diagnosis.findings, start=1)
            for n in f.tie
        ]
        heads = ["finding", "effect", "joint", "p_value", "share_percent"]
        heads += ["heldout_gain_percent", "heldout_std_percent"]
        return pd.DataFrame(rows, columns=heads).set_index("finding")

    def summary(self) -> Text:
        d = self.diagnosis
        lines = [wrapped(self.headline())]
        if d.findings:
            heads = ("finding", "share of excess", "held out", "parameters")
            lines.append(table(heads, [_row(f) for f in d.findings], numbers=(1, 2)))
        nearest = [p for p in d.places if p.state == "unexplained" and p.reason]
        lines += [wrapped(f"{p.joint}, {p.balance} side: {p.reason}", "  ") for p in nearest[:_SHOWN]]
        lines += [wrapped(s, "  ") for s in d.depends_on]
        lines += [wrapped(f"to separate: {asked}", "  ") for asked in separating(d.findings)]
        hidden = [f"{x.effect} at {x.joint}" for x in d.limits if x.reason]
        if hidden:
            more = f" and {len(hidden) - _SHOWN} more" if len(hidden) > _SHOWN else ""
            where = "the page says why, and which motion would"
            lines.append(wrapped(f"these logs cannot show {', '.join(hidden[:_SHOWN])}{more}; {where}", "  "))
        return Text("\n".join(lines))

    def plot(self) -> "Figure":
        """Every equation's residual over the floor, per band of frequency."""
        from pyident.verbs.figures.plots import heat_map

        return heat_map(self.diagnosis.rows)

    def save(self, path: str | Path, model: str = "") -> Path:
        """Write the page (HTML)."""
        from pyident.report.diagnosis_page import write_diagnosis

        return write_diagnosis(self.diagnosis, path, model)


@dataclass(frozen=True, repr=False)
class Added(Result):
    """A robot with one more effect, and whether held-out data bear it out.

    hinged   the robot with the effect and hinges that its motors feel; None: it has none of these
    """

    extended: "Extended"
    notes: tuple[str, ...]
    hinged: "Robot | None" = None

    @property
    def robot(self) -> "Robot":
        """The robot with the effect, fitted; also where it is refused."""
        return self.hinged or self.extended.robot

    @property
    def accepted(self) -> bool:
        """Whether held-out data bear the effect out."""
        return self.extended.accepted

    def headline(self) -> str:
        found = self.extended
        better = "it follows held-out data better"
        if found.gains[1] <= 0:
            better = "its equations follow held-out data better, its simulation does not"
        return found.reason or f"{self.robot.name}: {better}"

    def to_dict(self) -> dict[str, Any]:
        return self.extended.json() | {"notes": list(self.notes)}

    def to_frame(self) -> "pd.DataFrame":
        """A row per error: on which data, before, after, floor and unit."""
        import pandas as pd

        rows = [(s.name, s.data, s.before, s.after, s.floor, s.unit) for s in self.extended.waterfall]
        heads = ["error", "data", "before", "after", "floor", "unit"]
        return pd.DataFrame(rows, columns=heads).set_index("error")

    def summary(self) -> Text:
        heads = ("error", "data", "before", "after", "floor", "unit")
        rows = [
            (s.name, s.data, f"{s.before:.3g}", f"{s.after:.3g}", f"{s.floor:.3g}", s.unit)
            for s in self.extended.waterfall
        ]
        values = [
            f"{name} = {p['value']:.5g} {p['unit']}".removesuffix(" 1")
            + ("" if p.get("determined", True) else " (not determined by itself)")
            for name, p in self.extended.json()["parameters"].items()
        ]
        c = self.extended.correction
        if c and c.before:
            values.append(f"{c.place}: {c.before} becomes {c.after}")
        return Text("\n".join([table(heads, rows, numbers=(2, 3, 4)), *values, wrapped(self.headline())]))

    def plot(self) -> "Figure":
        """Errors on held-out and fitted data over their floors, without and with the effect."""
        from pyident.verbs.figures.plots import waterfall

        return waterfall(self.extended.waterfall)

    def save(self, path: str | Path) -> Path:
        """Write the robot file. Raises RobotError where the effect was refused."""
        from flexmodels.files.robot_file import save_robot
        from flexmodels.robot import RobotError

        if not self.accepted:
            raise RobotError(f"{path} is not written: {self.extended.reason}")
        save_robot(self.robot, path)
        return Path(path)


def side_by_side(models: Sequence[str], found: Sequence[Compared]) -> Text:
    """One or several models on the same logs, a column each."""
    several = len(found) > 1
    parts = [
        wrapped(f"{m}: {c.headline()}" if several else c.headline())
        for m, c in zip(models, found, strict=True)
    ]
    heads = ["signal", "unit"]
    for number in range(len(found)):
        model = f" {number + 1}" if several else ""
        heads += [f"rmse{model}", f"% of signal{model}", f"x floor{model}"]
    heads.append("floor %")
    for i, log in enumerate(found[0].comparison.logs):
        told = [dict(_told(c.comparison.logs[i])) for c in found]
        rows = []
        for name in dict.fromkeys(name for errors in told for name in errors):
            errors = [t.get(name) for t in told]
            unit = next(e.unit for e in errors if e)
            values = [(e.rmse, e.nrmse_percent, e.ratio) if e else (None,) * 3 for e in errors]
            cells = [_cell(v) for three in values for v in three]
            rows.append([name, unit, *cells, _cell(errors[-1] and errors[-1].floor_percent)])
        parts.append(table(heads, rows, title=log.log, numbers=range(2, len(heads))))
    return Text("\n".join(parts))


def _cell(value: float | None) -> str:
    """Three digits; a dash for what is not known."""
    return "-" if value is None or value != value else f"{value:.3g}"


def _told(log: Any) -> list[tuple[str, Any]]:
    """Every error of a log under a name that says what it is of."""
    return [(f"equation {n}", e) for n, e in log.equations.items()] + [
        (f"simulated {n}", e) for n, e in log.simulation.items()
    ]


def _row(finding: Any) -> tuple[str, str, str, str]:
    from pyident.diagnosis.verdict import said_share

    best = finding.tie[0]
    held, std = finding.heldout_gain_percent, finding.heldout_std_percent
    unseen = "-" if held is None else said_share(held, std)
    loose = [name for name in best.values if not best.determines(name)]
    told = [said_value(best, name) for name in best.values if name not in loose]
    together = " by themselves" if len(loose) > 1 else " by itself"
    values = ", ".join([*told, *([f"{', '.join(loose)} not determined{together}"] if loose else [])])
    names = " or ".join(n.where for n in finding.tie)
    share = said_share(finding.share_percent) if finding.share_percent else "-"
    return names, share, unseen, values


def said_value(named: Any, parameter: str) -> str:
    """A parameter of a named effect, where the logs determine it."""
    if not named.determines(parameter):
        return f"{parameter} not determined by itself"
    unit = "" if named.units[parameter] == "1" else f" {named.units[parameter]}"
    return f"{parameter} = {named.values[parameter]:.4g}{unit}"
