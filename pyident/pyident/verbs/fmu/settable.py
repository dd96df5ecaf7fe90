"""What a caller may set of an FMU, each variable once."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from flexfmu.foreign.model import FmuModel
from flexmodels.robot import RobotError
from pyident.greybox.recording import Recording
from pyident.verbs.fmu.arguments import Parameters

Values = Mapping[str, float]


def require_settable(fmu: FmuModel, model: str | Path, names: Values) -> None:
    """Raises RobotError for a variable (name -> value) that the FMU has not, or that cannot be set so."""
    for name in names:
        if name not in fmu.quantities:
            raise RobotError(f"{model} has no variable {name}; {_offer(fmu)}")
        if not fmu.quantities[name].can_be_set:
            raise RobotError(f"{model}: {name} is computed by the FMU and cannot be set; {_offer(fmu)}")
        if not fmu.quantities[name].continuous and names[name] != round(names[name]):
            raise RobotError(f"{model}: {name} takes whole numbers, not {names[name]:g}")


def require_unfed(recordings: Sequence[Recording], values: Values) -> None:
    """Raises RobotError for a value of an input that a log's column feeds."""
    fed = ((name, r.source) for r in recordings for name in r.inputs if name in values)
    for name, source in fed:
        raise RobotError(f"{source}: its column {name} feeds that input; leave out its value, or the column")


def require_apart(parameters: Parameters, values: Values | None) -> None:
    """Raises RobotError for a parameter that is named twice, or has a value for good beside."""
    names = list(parameters)
    for name in names:
        if names.count(name) > 1:
            raise RobotError(f"{name} is named twice among the parameters")
        if name in (values or {}):
            raise RobotError(f"{name} is to be identified and has a value for good; leave out one of them")


def _offer(fmu: FmuModel) -> str:
    names = fmu.of("parameter") or [q.name for q in fmu.quantities.values() if q.can_be_set]
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return f"its parameters are {', '.join(names[:8])}{more}" if names else "it has no parameters"
