"""Which law would take a stretch of a residual: asked of one bump, where `diagnose` judges all logs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmodels.inputs import SimulationError
from pyident.logs.log import LogError
from pyident.regression.machine.linear_algebra import one_thread
from pyident.verbs.inputs import Columns, Logs, Model, given, robot_of
from pyident.verbs.judged import Compared
from pyident.verbs.result import Result
from pyident.verbs.terminal.table import table
from pyident.verbs.text import Text, wrapped

if TYPE_CHECKING:
    import pandas as pd

    from pyident.diagnosis.stretches.ranking import Ranking
    from pyident.diagnosis.stretches.waves import Waves

Progress = Callable[[float], None]
_LISTED = 12  # laws of a summary
NOTHING = "The residual is no larger there than its floor: there is nothing to explain."
_OWN = "New values of the model's own laws take"
_ALL = 99.5  # per cent that read as all


@dataclass(frozen=True, repr=False)
class Explained(Result):
    """The laws in the order of what each takes of one stretch; a ranking, no verdict."""

    ranking: "Ranking"
    notes: tuple[str, ...] = ()

    def headline(self) -> str:
        r = self.ranking
        where = f"{r.coordinate} of {Path(r.log).name}, {r.span[0]:.4g} to {r.span[1]:.4g} s"
        where += f", {r.band[0]:.4g} to {r.band[1]:.4g} Hz" if r.band else ""
        if r.over_floor <= 1:
            return f"{where}: {NOTHING}"
        if r.own_leaves <= 1:
            return f"{where}: {self.own}"
        if not r.shares:
            return f"{where}: no law of the catalogue acts there."
        best, most = " or ".join(s.law.name for s in r.tie), r.shares[0].shown
        share = "all" if most >= _ALL else f"{most:.0f} %"
        return (
            f"{where}: {best} takes {share} of what new values of the model's own laws leave over the floor."
        )

    @property
    def own(self) -> str:
        """What new values of the model's own laws take, in words."""
        r = self.ranking
        if r.over_floor <= 1:
            return NOTHING
        if r.own_leaves <= 1:
            return f"{_OWN} all that exceeds the floor: its values are off, and nothing is left for a law."
        share = "nearly all" if r.own_percent >= _ALL else f"{max(r.own_percent, 0.0):.0f} %"
        return f"{_OWN} {share} of what exceeds the floor, and leave {r.own_leaves:.2g} times the floor."

    def to_frame(self) -> "pd.DataFrame":
        """A row per law: share in per cent, and whether the stretch can tell it from the best one."""
        import pandas as pd

        rows = [(s.law.effect, s.law.joint, s.percent, s.tied) for s in self.ranking.shares]
        return pd.DataFrame(rows, columns=["effect", "joint", "share_percent", "tied"])

    def to_dict(self) -> dict[str, Any]:
        r = self.ranking
        laws = [
            {
                "effect": s.law.effect,
                "joint": s.law.joint,
                "share_percent": s.percent,
                "tied": s.tied,
                "parameters": {n: {"value": v, "unit": s.law.units[n]} for n, v in s.law.values.items()},
            }
            for s in r.shares
        ]
        return {
            "log": r.log,
            "coordinate": r.coordinate,
            "span": list(r.span),
            "band": list(r.band) if r.band else None,
            "over_floor": r.over_floor,
            "own_laws_percent": r.own_percent,
            "own_laws_leave_over_floor": r.own_leaves,
            "laws": laws,
            "notes": list(self.notes),
        }

    def summary(self) -> Text:
        ranked = self.ranking.shares[:_LISTED] if self.ranking.own_leaves > 1 else ()
        rows = [(s.law.name, f"{s.shown:.0f} %", "like the best" if s.tied else "") for s in ranked]
        least = (
            "A ranking of one stretch is no verdict; pyident diagnose judges all equations on unseen data."
        )
        said = self.headline()
        lines = [wrapped(line) for line in (said, *([] if self.own in said else [self.own]), least)]
        heads = [table(("law", "share", ""), rows, numbers=(1,))] if rows else []
        return Text("\n".join([*heads, *lines]))


def explain(
    model: Model,
    logs: Logs,
    *,
    log: str | None = None,
    coordinate: str | None = None,
    span: tuple[float, float] | None = None,
    band: tuple[float, float] | None = None,
    heldout: Logs = (),
    mapping: Columns | None = None,
    parameters: Mapping[str, float] | None = None,
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> Explained:
    """Which law would take a stretch of a residual: the laws by what each takes of it.

    log          where the stretch is, as given or its file's name; none: the first
    coordinate   of the equation; none: the one that fails most
    span         from and to [s]; none: the whole log
    band         from and to [Hz]; none: up to where the equation stands above its floor
    heldout      logs that may be asked about, but to which nothing is fitted
    The others as in `compare`. Raises RobotError, LogError, SimulationError.
    """
    from pyident.verbs.judge import compare

    robot = robot_of(model, parameters, allow_effects)
    read = given(robot, logs, mapping, heldout, force)
    told = progress or (lambda _: None)
    every = [*read.logs, *read.heldout]
    _require([one.source for one in every], log, read.robot.coordinates, coordinate)
    compared = compare(robot, every, force=force, progress=lambda share: told(0.8 * share))
    if not compared.comparison.traces:
        raise SimulationError(compared.comparison.sentence)
    after = partial(_later, told)
    waves = waves_of(compared, robot, read.logs, heldout=read.heldout, force=force, progress=after)
    worst = compared.comparison.where
    trace = compared.comparison.traces[0]
    name = coordinate or (worst.coordinate if worst else trace.coordinate)
    return explained(compared, waves, log or trace.log, name, span, band)


def _later(told: Progress, share: float) -> None:
    told(0.8 + 0.2 * share)


@one_thread()
def waves_of(
    compared: Compared,
    model: Model,
    logs: Logs,
    *,
    heldout: Logs = (),
    mapping: Columns | None = None,
    allow_effects: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> "Waves":
    """What every law would take of every equation over time, from which `explained` answers at once.

    compared  the model with all of these logs
    heldout   logs along which the laws are followed, too, but to which nothing is fitted
    The others as in `compare`. Raises RobotError, LogError.
    """
    from pyident.diagnosis.stretches.waves import waves

    read = given(robot_of(model, allow_effects=allow_effects), logs, mapping, heldout, force)
    floor = compared.comparison.floor
    assert floor is not None  # every comparison with replicas has one
    return waves(read.robot, read.logs, floor, read.heldout, progress or (lambda _: None))


def explained(
    compared: Compared,
    waves: "Waves",
    log: str,
    coordinate: str,
    span: tuple[float, float] | None = None,
    band: tuple[float, float] | None = None,
) -> Explained:
    """One stretch of a comparison. log: as given or its file's name; span [s], band [Hz], None: all.

    Raises LogError where there is no such log, equation or frequency.
    """
    from pyident.diagnosis.stretches.ranking import ranking

    traces = compared.comparison.traces
    _require([t.log for t in traces], log, [t.coordinate for t in traces], coordinate)
    named = next(t.log for t in traces if log in (t.log, Path(t.log).name))
    trace = compared.comparison.trace(named, coordinate, band)
    return Explained(ranking(waves, trace, span), compared.notes)


def _require(
    logs: Sequence[str], log: str | None, coordinates: Sequence[str], coordinate: str | None
) -> None:
    """Raises LogError for a log or an equation that is asked about and not there."""
    for what, names, asked in (
        ("log", [*logs, *(Path(name).name for name in logs)], log),
        ("equation", coordinates, coordinate),
    ):
        if asked is not None and asked not in names:
            there = ", ".join(dict.fromkeys(names))
            raise LogError(f"there is no {what} {asked} to explain; there are {there}")
