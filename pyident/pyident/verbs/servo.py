"""Logs of servos without torque -> parameters, in closed loop on positions alone."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmodels.files.robot_file import save_robot
from flexmodels.link import LINK_PARAMETERS
from flexmodels.named_values import settable, with_settings
from flexmodels.robot import Robot, RobotError
from flexmodels.settings.servo import PER_JOINT, SHARED
from pyident.logs.log import Log
from pyident.refinement.closed_loop import ClosedLoopFit, ServoLog, fit_closed_loop
from pyident.simulation.fmu_runs import batches_here
from pyident.verbs.inputs import Columns, Logs, Model, mapping_of, read_logs, robot_of
from pyident.verbs.result import Result
from pyident.verbs.text import Text, table, wrapped

if TYPE_CHECKING:
    import pandas as pd

_CONFIDENCE = 1.96  # standard deviations on both sides hold 95 % of a normal distribution


@dataclass(frozen=True, repr=False)
class ServoFit(Result):
    """What `identify_servo` found; notes: a sentence each."""

    fit: ClosedLoopFit
    logs: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def robot(self) -> Robot:
        """The robot with the values found."""
        return self.fit.robot

    def save(self, path: str | Path) -> Path:
        """Write the robot file. Raises RobotError."""
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
        followed = f"positions followed to {max(self.fit.error):.3g} rad or m"
        return f"{self.robot.name}: {followed} on the worst of {len(self.logs)} logs"

    def summary(self) -> Text:
        rows = [
            (f"{r.value:.5g}", f"{_CONFIDENCE * r['std']:.2g}" if self.fit.std else "-", r.unit, str(name))
            for name, r in self.to_frame().iterrows()
        ]
        lines = [
            f"{log}: mean absolute position error {e:.3g} rad or m"
            for log, e in zip(self.logs, self.fit.error, strict=True)
        ]
        if self.fit.std is None:
            lines.append("intervals need three logs or more: they are a jackknife over logs")
        return Text(
            "\n".join(
                [
                    table(("value", "± 95 %", "unit", "parameter"), rows, numbers=(0, 1)),
                    *(wrapped(x, "  ") for x in lines),
                ]
            )
        )

    def _unit(self, name: str) -> str:
        known = self.robot.units
        return known[name] if name in known else (PER_JOINT | SHARED)[name.rpartition(".")[2]][0]


def identify_servo(
    model: Model,
    logs: Logs,
    *,
    mapping: Columns | None = None,
    free: Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
    settings: Sequence[Mapping[str, float]] = (),
    allow_effects: bool = False,
    progress: Callable[[float], None] | None = None,
) -> ServoFit:
    """Friction, inertia and drive of servo-driven joints from commands and positions (output error).

    model       with a [servo] table; its values are the start
    free        names to find; none: every law at the joints and what [servo] lists as `unknown`. Masses and
                inertias of links stay, as positions alone give torques only up to a factor
    parameters  known values of all logs, such as {"servo.kp": 400}
    settings    known values that differ from log to log, a mapping for each
    Raises RobotError, LogError, SimulationError.
    """
    robot = robot_of(model, parameters, allow_effects)
    if robot.servo is None:
        raise RobotError(f"robot {robot.name} has no [servo]; describe its drives, or identify from torques")
    read = read_logs(robot, logs, mapping_of(mapping))
    recordings = _with_settings(robot, read, settings)
    names = list(free) or [
        *robot.servo.free,
        *(name for name in robot.parameters if name.partition(".")[2] not in LINK_PARAMETERS),
    ]
    unknown = [name for name in names if name not in settable(robot)]
    if unknown:
        raise RobotError(f"robot {robot.name} has no parameter {unknown[0]} that could be found")
    with batches_here(robot) as simulate:
        found = fit_closed_loop(robot, recordings, names, simulate)
    if progress:
        progress(1.0)
    notes = tuple(note for log in read for note in log.notes)
    return ServoFit(found, tuple(log.source for log in read), notes)


def _with_settings(
    robot: Robot, logs: Sequence[Log], settings: Sequence[Mapping[str, float]]
) -> list[ServoLog]:
    if settings and len(settings) != len(logs):
        raise RobotError(f"{len(settings)} settings for {len(logs)} logs; give one for each log")
    known = list(settings) or [{}] * len(logs)
    for values in known:
        with_settings(robot, values)
    return [ServoLog(log, values) for log, values in zip(logs, known, strict=True)]
