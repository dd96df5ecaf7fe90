"""What `excite` and `check_plan` return."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pyident.verbs.result import Result
from pyident.verbs.terminal.table import table
from pyident.verbs.text import Text, finite, half_interval, wrapped

if TYPE_CHECKING:
    import pandas as pd

    from flexmodels.inputs import Experiment
    from flexmodels.robot import Robot
    from pyident.excitation.design import Design
    from pyident.excitation.prediction import Prediction
    from pyident.excitation.rehearsals.violations import Violation

ENOUGH = 5.0  # standard deviations that settle a question


@dataclass(frozen=True)
class Promise:
    """How far apart two rivals will be, in standard deviations of the sensors' noise, after a refit.

    robots   the models that were compared: what is promised holds for effects of their values
    """

    rivals: tuple[str, str]
    sigmas: float
    robots: "tuple[Robot, Robot]"

    @property
    def sentence(self) -> str:
        which = "which settles it" if self.sigmas >= ENOUGH else "which does not settle it"
        return f"{' and '.join(self.rivals)} will differ by {self.sigmas:.3g} standard deviations, {which}"

    @property
    def supposed(self) -> dict[str, dict[str, float]]:
        """Rival -> the parameters of its law, by name; none of one that is no effect."""
        found: dict[str, dict[str, float]] = {}
        for name, robot in zip(self.rivals, self.robots, strict=True):
            effect, at, joint = name.partition("@")
            if at:
                found[name] = dict(robot.joints[int(joint) - 1].values[effect])
        return found


@dataclass(frozen=True, repr=False)
class Planned(Result):
    """A motion that the robot can run, and what it will tell.

    design      plan, search and rehearsals
    prediction  of the parameters' standard deviations;  promise  of a separation, None where none was asked
    """

    robot: "Robot"
    design: "Design"
    notes: tuple[str, ...]
    prediction: "Prediction"
    promise: Promise | None

    @property
    def plan(self) -> "Experiment":
        """What `simulate` runs."""
        return self.design.plan

    def save(self, path: str | Path) -> Path:
        """Write the plan: time, joint{k}.r and joint{k}.tau_ff (.csv, .parquet or .mat). Raises LogError."""
        from pyident.excitation.rehearsals.rehearsal import plan_frame
        from pyident.logs.log import Log, write_log

        write_log(Log(plan_frame(self.plan), "the plan"), path)
        return Path(path)

    def to_frame(self) -> "pd.DataFrame":
        """A row per parameter: value, standard deviation by `identify` and by regression, unit."""
        return _parameters(self.robot, self.prediction)

    def to_dict(self) -> dict[str, Any]:
        found = _prediction(self.robot, self.prediction) | {
            "duration_s": float(self.plan.time[-1]),
            "evaluations": self.design.offer.best.evaluations,
            "stopped": self.design.offer.best.stopped,
            "scale": self.design.scale,
            "multisine": _rms(self.plan),
            "binding": self.design.binding,
            "spread": self.design.spread,
            "rehearsed": self.design.rehearsed,
            "notes": list(self.notes),
        }
        if self.promise is not None:
            separation = {"rivals": list(self.promise.rivals), "sigmas": self.promise.sigmas}
            found |= {"separation": separation | {"supposed": self.promise.supposed}}
        return found

    def headline(self) -> str:
        what = self.promise.sentence if self.promise else _rank(self.prediction)
        return f"{self.robot.name}, a motion of {self.plan.time[-1]:g} s: {what}"

    def summary(self) -> Text:
        search = self.design.offer.best
        lines = [wrapped(self.headline(), "  ")] if self.promise else []
        for name, values in (self.promise.supposed if self.promise else {}).items():
            listed = ", ".join(f"{of} = {value:.3g}" for of, value in values.items())
            lines.append(wrapped(f"supposed of {name}: {listed} (SI units)", "  "))
        lines.append(_told(self.robot, self.prediction))
        ended = ", stopped early" if search.stopped else ""
        lines.append(
            f"{search.evaluations} motions tried{ended}; rehearsed by {self.design.rehearsed} robots with "
            f"every parameter {100 * self.design.spread:g} % off, at {100 * self.design.scale:.0f} % of its "
            "first size"
            + (
                f", as far as {self.design.binding} allows; a smaller --spread leaves more"
                if self.design.binding
                else ""
            )
        )
        return Text("\n".join(lines))


@dataclass(frozen=True, repr=False)
class Checked(Result):
    """Whether a robot may run a plan: violations, none where it may.

    others   robots with other parameters that rehearsed it;  broken: how many of them broke a limit
    """

    robot: "Robot"
    violations: "tuple[Violation, ...]"
    notes: tuple[str, ...]
    prediction: "Prediction"
    others: int
    broken: int

    @property
    def safe(self) -> bool:
        """Whether no run broke a limit."""
        return not self.violations

    def to_frame(self) -> "pd.DataFrame":
        """A row per violation: what, where, whose, value, limit, unit, time."""
        import pandas as pd

        heads = ["what", "where", "of", "value", "limit", "unit", "time"]
        rows = [[getattr(v, head) for head in heads] for v in self.violations]
        return pd.DataFrame(rows, columns=heads)

    def to_dict(self) -> dict[str, Any]:
        return _prediction(self.robot, self.prediction) | {
            "safe": self.safe,
            "violations": self.to_frame().to_dict("records"),
            "rehearsed": self.others,
            "broken": self.broken,
            "notes": list(self.notes),
        }

    def headline(self) -> str:
        if self.safe:
            others = f", and so do {self.others} robots like it" if self.others else ""
            return f"{self.robot.name} keeps every limit{others}"
        which = f", by {self.broken} of {self.others} robots like it" if self.broken else ""
        count = len(self.violations)
        are = "1 limit is" if count == 1 else f"{count} limits are"
        return f"{self.robot.name} must not run this: {are} broken{which}"

    def summary(self) -> Text:
        lines = [self.headline(), *(wrapped(f"  {v.sentence}", "    ") for v in self.violations)]
        return Text("\n".join([*lines, _told(self.robot, self.prediction)]))


def _rms(plan: "Experiment") -> dict[str, float]:
    """Of every joint's multisine [N m or N]."""
    rms = np.sqrt(np.mean(plan.feedforward**2, axis=0))
    return {f"joint{k}": float(value) for k, value in enumerate(rms, start=1)}


def _parameters(robot: "Robot", found: "Prediction") -> "pd.DataFrame":
    import pandas as pd

    by_name = {"value": found.values, "std": found.std, "std_regression": found.std_regression}
    frame = pd.DataFrame(by_name | {"unit": {name: robot.units[name] for name in found.values}})
    return frame.rename_axis("parameter")


def _prediction(robot: "Robot", found: "Prediction") -> dict[str, Any]:
    return {
        "parameters": {
            name: {
                "value": found.values[name],
                "std": finite(std),
                "std_regression": finite(found.std_regression[name]),
                "unit": robot.units[name],
            }
            for name, std in found.std.items()
        },
        "rank": found.rank,
        "singular_values": found.singular_values.tolist(),
        "condition_number": found.condition,
    }


def _rank(found: "Prediction") -> str:
    return f"rank {found.rank} of {len(found.std)} parameters, condition number {found.condition:.3g}"


def _told(robot: "Robot", found: "Prediction") -> str:
    fitted = bool(np.isfinite(list(found.std.values())).any())
    told = found.std if fitted else found.std_regression
    rows = [
        (name, f"{value:.5g}", half_interval(told[name]), robot.units[name])
        for name, value in found.values.items()
        if np.isfinite(told[name]) or np.isfinite(found.std_regression[name])
    ]
    half = f"± 95 % by {'identify' if fitted else 'a plain regression'}"
    lines = [table(("parameter", "in the model", half, "unit"), rows, numbers=(1, 2))]
    lines.append(f"{_rank(found)}; the others only in combinations")
    if any(half == "-" for _, _, half, _ in rows):
        lines.append("-: a log tells it, but `identify` gives it no interval")
    if any(found.values[name] == 0 for name, *_ in rows):
        zero = "a 0 in the model may be a value that nobody has identified yet: ± 95 % says how closely a log"
        lines.append(wrapped(f"{zero} of this motion would give it"))
    return "\n".join(lines)
