"""What `identify`, `refine` and `identify_servo` return."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyident.refinement.auxiliary_model import by_instruments
from pyident.refinement.instruments.logged import quiet
from pyident.verbs.result import Result
from pyident.verbs.terminal.table import table
from pyident.verbs.text import Text, half_interval, wrapped

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from flexmodels.robot import Robot
    from pyident.estimation.identify import Identified
    from pyident.logs.disk import LogFile
    from pyident.logs.log import Log
    from pyident.refinement.closed_loop import ClosedLoopFit

_FAR = 2.0  # times the estimate's error
_COMBINATIONS = 4  # base parameters that a sentence writes out
_HARDLY = 0.5  # of what a joint that stays at its command leaves: more is no simulation of it
_BEHIND = "torques of sensors behind the gears, which hold nothing of the motors, "
_FAR_FROM_NOISE = 3.0  # times: less may be noise that is not white


@dataclass(frozen=True, repr=False)
class Fit(Result):
    """A robot with parameters that follow from logs.

    identified  solution, its support by the data, base parameters
    notes       what was done to logs and robot, a sentence each
    logs        that it was fitted to
    heldout     log -> joint -> error of the written model's torque [%], of logs that it was not fitted to
    prior       near which the model is written where the data leave it open
    hinged      the robot with hinges that its motors feel; None: as it was identified
    """

    identified: "Identified"
    notes: tuple[str, ...]
    logs: tuple["Log | LogFile", ...] = ()
    heldout: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    prior: "Robot | None" = None
    hinged: "Robot | None" = None

    @property
    def robot(self) -> "Robot":
        """The robot with its new, physically consistent parameters."""
        return self.hinged or self.identified.robot

    def save(self, path: str | Path) -> Path:
        """Write the robot file. Raises RobotError."""
        from flexmodels.files.robot_file import save_robot

        save_robot(self.robot, path)
        return Path(path)

    def save_page(self, path: str | Path) -> Path:
        """Write an HTML page: errors, parameters, correlations, spectra of what is left of the torques."""
        from pyident.estimation.residuals import joint_residuals
        from pyident.logs.log import Log
        from pyident.report.identification import write_identification

        logs = [log for log in self.logs if isinstance(log, Log)]
        left = joint_residuals(self.identified.robot, logs) if logs else []
        return write_identification(Path(path), self.identified, self.notes, left, self.heldout, self.prior)

    def to_frame(self) -> "pd.DataFrame":
        """A row per parameter: value, std, unit, and whether the data tell it alone."""
        import pandas as pd

        rows = self.to_dict()["parameters"]
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("parameter")

    def base_frame(self) -> "pd.DataFrame":
        """A row per base parameter, the combinations that the data determine: value, std, unit."""
        import pandas as pd

        units = self.robot.units
        rows = [(b.expression, b.value, b.std, units[b.terms[0][1]]) for b in self.identified.base]
        return pd.DataFrame(rows, columns=["expression", "value", "std", "unit"]).set_index("expression")

    def plot(self) -> "Figure":
        """How well the data tell each base parameter: its 95 % interval over its value."""
        from pyident.verbs.figures.plots import determination

        return determination(self.identified.base)

    def to_dict(self) -> dict[str, Any]:
        from pyident.estimation.identify import told_errors

        heldout = {source: told_errors(error) for source, error in self.heldout.items()}
        told = {"relative_error_heldout_percent": heldout} if heldout else {}
        found = self.identified.json()
        for name in sorted(set(self.robot.parameters) - set(found["parameters"])):
            value, unit = self.robot.parameters[name], self.robot.units[name]
            found["parameters"][name] = {"value": value, "std": None, "unit": unit, "identifiable": "alone"}
        return found | told | {"notes": list(self.notes)}

    def headline(self) -> str:
        found = self.identified
        return (
            f"{self.robot.name}, {len(found.reduced.columns)} parameters, rank {found.solution.rank}, "
            f"relative torque error {found.relative_error['all']:.3g} %"
        )

    def determined(self) -> str:
        """How much of the parameters these logs determine, in words."""
        support = list(self.identified.support.values())
        alone, never = support.count("alone"), support.count("no")
        sums = [b.expression for b in self.identified.base if len(b.terms) > 1]
        words = f"{alone} of {len(support)} parameters are determined alone"
        if sums:
            many = "" if len(sums) == 1 else "s"
            words += f", {support.count('combination')} more only in {len(sums)} combination{many}"
        words += f", {never} act on nothing that was measured." if never else "."
        if sums:
            more = ", …" if len(sums) > _COMBINATIONS else ""
            words += f" The combinations: {'; '.join(sums[:_COMBINATIONS])}{more}"
        return words

    def summary(self) -> Text:
        from pyident.estimation.base_parameters import weakest_directions

        found, units = self.identified, self.robot.units
        rows = [
            (f"{b.value:.6g}", half_interval(b.std), units[b.terms[0][1]], b.expression) for b in found.base
        ]
        heads = ("value", "± 95 %", "unit", "base parameter")
        weak = weakest_directions(found.reduced, found.solution)
        lines = [f"{found.estimator}: {len(found.reduced.columns)} parameters, rank {found.solution.rank}"]
        lines += [wrapped(f"  {sentence}", "    ") for sentence in weak]
        return Text("\n".join([table(heads, rows, numbers=(0, 1)), *lines, *self._errors()]))

    def _errors(self) -> list[str]:
        written = self.identified.model_error
        what = "of the estimate" if written else "of the regression"
        lines = [f"relative torque error {what}: {_percentages(self.identified.relative_error)}"]
        if written:
            lines.append(f"relative torque error of the model that is written: {_percentages(written)}")
            if written["all"] > max(100, _FAR * self.identified.relative_error["all"]):
                lines.append(
                    "do not use the model that is written: it leaves more than the torques themselves, as "
                    "these logs show too little of the bodies; logs in which all joints move tell more"
                )
            bound = self.identified.at_bound
            if bound:
                behind = _BEHIND if _of_motors(bound) else ""
                lines.append(
                    f"written at the least value that it may have: {', '.join(bound)}; an effect that is "
                    f"missing, a wrong sign, {behind}or too little motion to tell"
                )
        drowned = [k for k, e in self.identified.relative_error.items() if k != "all" and e > 100]
        if drowned:
            lines.append(
                f"above 100 % at {', '.join(drowned)}: noise of the positions, differentiated twice, exceeds "
                "the torque there, and the figure says nothing of the model; give [processing] of the robot "
                "file a cutoff of a few times the highest frequency of the motion"
            )
        elif written:
            lines.append(f"{self._what_errors_hold}: pyident compare tells what noise alone would leave")
        lines += [f"the same on {source}, held out: {_percentages(e)}" for source, e in self.heldout.items()]
        return [wrapped(line, "  ") for line in lines]

    @property
    def _what_errors_hold(self) -> str:
        if by_instruments(self.identified) and quiet(self.identified.robot):
            return "these errors hold the noise of the torques, and none of the positions"
        return "these errors hold the sensors' noise, that of positions differentiated twice"


@dataclass(frozen=True, repr=False)
class ServoFit(Result):
    """What `identify_servo` found; notes: a sentence each."""

    fit: "ClosedLoopFit"
    logs: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def robot(self) -> "Robot":
        """The robot with the values found."""
        return self.fit.robot

    def save(self, path: str | Path) -> Path:
        """Write the robot file. Raises RobotError."""
        from flexmodels.files.robot_file import save_robot

        save_robot(self.robot, path)
        return Path(path)

    def to_frame(self) -> "pd.DataFrame":
        """A row per parameter: value, std (NaN with fewer than three logs), unit."""
        import pandas as pd

        names, std = list(self.fit.values), self.fit.std or {}
        columns = {"value": list(self.fit.values.values()), "std": [std.get(n, float("nan")) for n in names]}
        frame = pd.DataFrame(columns, index=pd.Index(names, name="parameter"))
        return frame.assign(unit=[self._unit(name) for name in names])

    def to_dict(self) -> dict[str, Any]:
        return self.fit.json() | {"logs": list(self.logs), "notes": list(self.notes)}

    def headline(self) -> str:
        followed = f"positions followed to {max(self.fit.error):.3g} {self._of_motion()}"
        return f"{self.robot.name}: {followed} on the worst of {len(self.logs)} logs"

    def summary(self) -> Text:
        frame = self.to_frame()
        columns = frame["value"].to_numpy(float), frame["std"].to_numpy(float), frame["unit"], frame.index
        rows = [(f"{v:.5g}", half_interval(s), u, str(n)) for v, s, u, n in zip(*columns, strict=True)]
        lines = [*self._followed(), *self._doubts()]
        if self.fit.std is None:
            lines.append("intervals need three logs or more: they are a jackknife over logs")
        heads = ("value", "± 95 %", "unit", "parameter")
        return Text("\n".join([table(heads, rows, numbers=(0, 1)), *(wrapped(x, "  ") for x in lines)]))

    def _followed(self) -> Iterator[str]:
        """A sentence on each log."""
        known = self.fit.unmodelled or (float("nan"),) * len(self.logs)
        for log, error, alone in zip(self.logs, self.fit.error, known, strict=True):
            share = f", {100 * error / alone:.2g} % of what the commands alone leave" if alone > 0 else ""
            yield f"{log}: mean absolute position error {error:.3g} {self._of_motion()}{share}"

    def _doubts(self) -> Iterator[str]:
        """Why the values should not be relied on as they are."""
        fit = self.fit
        if sum(fit.error) > _HARDLY * sum(fit.unmodelled) > 0:
            yield (
                "do not use these values: the simulation comes hardly nearer to the positions than their "
                "commands do; check the logs' columns, units and clock, and what the robot file says of the "
                "servos"
            )
        elif self._over_noise > _FAR_FROM_NOISE:
            apart = ", or a gain was another one in some logs (--set-in)" if len(self.logs) > 1 else ""
            yield (
                f"that is {self._over_noise:.2g} times what the encoders' noise leaves: an effect is "
                f"missing, or a log's scale or clock is wrong{apart}; pyident compare tells where, pyident "
                "diagnose what"
            )
        if fit.at_bound:
            yield (
                f"at the least value that it may have: {', '.join(fit.at_bound)}; an effect that is missing, "
                "a log's scale or clock that is wrong, or too little motion to tell"
            )
        if fit.unseen:
            yield f"as they were given, since no position moves with them: {', '.join(fit.unseen)}"

    @property
    def _over_noise(self) -> float:
        """How many times what noise leaves the errors of all logs are, as one log bends what fits another."""
        noise = sum(self.fit.noise)
        return sum(self.fit.error) / noise if noise else 0.0

    def _of_motion(self) -> str:
        kinds = {"rad" if joint.kind == "revolute" else "m" for joint in self.robot.joints}
        return " or ".join(sorted(kinds, reverse=True))

    def _unit(self, name: str) -> str:
        from flexmodels.settings.servo import PER_JOINT, SHARED

        known = self.robot.units
        return known[name] if name in known else (PER_JOINT | SHARED)[name.rpartition(".")[2]][0]


def _percentages(errors: Mapping[str, float]) -> str:
    return ", ".join(f"{j} {error:.4g} %" if error == error else f"{j} -" for j, error in errors.items())


def _of_motors(names: Sequence[str]) -> bool:
    """Whether all are what sensors behind the gears do not show."""
    return all(name.endswith((".J_m", ".coulomb", ".viscous")) for name in names)
