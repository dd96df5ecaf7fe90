"""What a caller gives beside logs where an FMU is the model; light, for the command line."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from flexfmu.foreign.interface import Interface

__all__ = ["Interface", "Parameters", "is_fmu"]

Parameters = Sequence[str] | Mapping[str, tuple[float, float] | None]


def is_fmu(model: object) -> bool:
    """Whether a model is the path of an FMU."""
    return isinstance(model, str | Path) and str(model).endswith(".fmu")
