"""Two sorts of logs, without and with a load -> what the load is."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmodels.link import LINK_PARAMETERS
from flexmodels.robot import Robot
from pyident.estimation.payload import Carried, carried, last_link
from pyident.logs.log import LogError
from pyident.verbs.fit import identify, with_found_drive
from pyident.verbs.inputs import Columns, Logs, Model, robot_of
from pyident.verbs.result import Result
from pyident.verbs.terminal.table import table
from pyident.verbs.text import Text, half_interval, wrapped

if TYPE_CHECKING:
    import pandas as pd

_STRANGE = 3.0  # standard deviations that a body may be off the regression's values
_OWN = ("motor_inertia", "coulomb", "viscous")  # laws that no drive is without
AXES = "the link's: parallel to the base's in the zero pose"


@dataclass(frozen=True, repr=False)
class Payload(Result):
    """What was added to the last link: ten inertial parameters about that link's joint, in its axes.

    These are parallel to the base's while the arm stands in its zero pose, and turn with the link.

    model   the robot as it was given;  carried   values, standard deviations, the nearest body
    """

    model: Robot
    carried: Carried
    notes: tuple[str, ...]

    @property
    def robot(self) -> Robot:
        """The model with the payload in its last link."""
        names = last_link(self.model)
        added = zip(names, self.carried.consistent, strict=True)
        values = {name: self.model.parameters[name] + float(v) for name, v in added}
        return self.model.with_parameters(values, f"{self.model.name}_loaded")

    @property
    def mass(self) -> float:
        """[kg]"""
        return float(self.carried.consistent[0])

    @property
    def centre(self) -> np.ndarray:
        """Centre of mass from the last link's joint, in its axes [m]."""
        return self.carried.consistent[1:4] / self.mass

    def save(self, path: str | Path) -> Path:
        """Write the loaded robot's file. Raises RobotError."""
        from flexmodels.files.robot_file import save_robot

        save_robot(self.robot, path)
        return Path(path)

    @property
    def not_identified(self) -> str:
        """What is in the robot file beside the load, in words."""
        said = (
            "what is written is the model as it was given, with the load in its last link: everything else, "
            "friction, too, is the model's own and was not identified here"
        )
        laws = [joint.values.get(law, {}) for joint in self.model.joints for law in _OWN]
        if any(value for values in laws for value in values.values()):
            return said
        return (
            f"{said}. Friction and rotor inertias are 0 in it: identify the model from the log without the "
            "load first (pyident identify ... -o), then call payload with what that wrote"
        )

    def to_frame(self) -> "pd.DataFrame":
        """A row per parameter: value, std (inf: not determined), consistent value, unit."""
        import pandas as pd

        one = self.carried
        columns = {"value": one.free, "std": one.std, "consistent": one.consistent}
        frame = pd.DataFrame(columns, index=pd.Index(LINK_PARAMETERS, name="parameter"))
        return frame.assign(unit=list(LINK_PARAMETERS.values()))

    def to_dict(self) -> dict[str, Any]:
        rows = self.to_frame().to_dict("index")
        for row in rows.values():
            row["std"] = row["std"] if np.isfinite(row["std"]) else None
        return {
            "link": self.model.last_link,
            "parameters": rows,
            "mass_kg": self.mass,
            "centre_m": self.centre.tolist(),
            "axes": AXES,
            "rank": self.carried.rank,
            "standard_deviations_off": self.carried.far,
            "within_noise_of_none": self.carried.none_fits,
            "notes": list(self.notes),
        }

    def headline(self) -> str:
        x, y, z = self.centre
        if self.carried.none_fits:
            return (
                f"these logs tell no load from none: link {self.model.last_link} would carry "
                f"{self.mass:.2g} kg, within the interval of nothing"
            )
        return f"link {self.model.last_link} carries {self.mass:.4g} kg at ({x:.4g}, {y:.4g}, {z:.4g}) m"

    def summary(self) -> Text:
        one = self.carried
        columns = (LINK_PARAMETERS.items(), one.free.tolist(), one.std.tolist(), one.consistent.tolist())
        rows = [
            (f"{value:.5g}", half_interval(std), f"{body:.5g}", unit, name)
            for (name, unit), value, std, body in zip(*columns, strict=True)
        ]
        heads = ("value", "± 95 %", "of a body", "unit", "added")
        axes = "turn with the link and are parallel to the base's in the zero pose"
        frame = f"from its joint, in axes that {axes} (a URDF's link may have others)"
        lines = [self.headline() if one.none_fits else f"{self.headline()}, {frame}"]
        if self.carried.rank < len(LINK_PARAMETERS):
            lines.append(self._undetermined())
        if self.carried.far > _STRANGE:
            lines.append(
                f"no body has the regression's values: the nearest is {self.carried.far:.2g} standard "
                "deviations off; is it the same robot, and does the load not swing or slip?"
            )
        return Text("\n".join([table(heads, rows, numbers=(0, 1, 2)), *(wrapped(x, "  ") for x in lines)]))

    def _undetermined(self) -> str:
        """What the motions leave open, in words."""
        count, known = self.carried.rank, np.isfinite(self.carried.std)
        alone = [name for name, one in zip(LINK_PARAMETERS, known, strict=True) if one]
        told = f"{', '.join(alone)} alone" if alone else "none of them alone"
        return (
            f"these motions determine {count} of ten combinations, {told}; what has no interval is one of "
            "many values that explain the logs alike, so turn more joints, with the load at other heights"
        )


def payload(
    model: Model,
    empty: Logs,
    loaded: Logs,
    *,
    mapping: Columns | None = None,
    allow_effects: bool = False,
    force: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Payload:
    """What a robot carries in some logs and not in others; the model's own values are never used.

    model     as in `identify`;  empty, loaded   logs without and with the load, best of one motion
    The others as in `identify`. Raises RobotError, LogError.
    """
    robot, drive = with_found_drive(robot_of(model, allow_effects=allow_effects), empty, mapping, force)
    share = (
        (lambda done: progress(done / 2), lambda done: progress(0.5 + done / 2)) if progress else (None, None)
    )
    without, having = (
        identify(robot, logs, mapping=mapping, force=force, progress=told)
        for logs, told in zip((empty, loaded), share, strict=True)
    )
    if without.identified.reduced.columns != having.identified.reduced.columns:
        raise LogError("the logs without and with the load do not hold the same signals; record them alike")
    for which, one in (("without", without), ("with", having)):
        if np.isnan(np.diag(one.identified.solution.covariance)).all():
            raise LogError(
                f"the fit of the logs {which} the load has no intervals to hold a load against: "
                f"{'; '.join(one.notes) or 'they are too long to be held in memory, so give shorter ones'}"
            )
    load = carried(without.robot, without.identified, having.identified)
    return Payload(robot, load, tuple(dict.fromkeys((*drive, *without.notes, *having.notes))))
