"""What an FMU file says of itself, by FMPy; nothing of it is run."""

import re
import zipfile
from pathlib import Path

from fmpy import platform, platform_tuple, read_model_description
from fmpy.model_description import ModelDescription, ScalarVariable, ValidationError

from flexmodels.inputs import SimulationError

_LARGEST = 4e9  # bytes of an FMU unpacked


class FmuDescription:
    """What an FMU file says of itself. Raises SimulationError for a file that is none.

    flaw   where it breaks the standard, which only a `lenient` reader forgives; else empty
    """

    def __init__(self, path: str | Path, lenient: bool = False):
        self.description, self.flaw = _described(Path(path), lenient)
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}

    @property
    def joints(self) -> int:
        """Number of driven joints: those with a reference among the inputs."""
        return sum(1 for name in self.references if re.fullmatch(r"joint\d+\.r", name))


def _described(path: Path, lenient: bool) -> tuple[ModelDescription, str]:
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(member.file_size for member in archive.infolist())
        if size > _LARGEST:
            raise SimulationError(f"{path} holds {size / 1e9:.3g} GB unpacked, too much for an FMU")
        try:
            return read_model_description(str(path)), ""
        except ValidationError as error:
            if not lenient:
                raise
            return read_model_description(str(path), validate=False), _first_reason(error)
    except FileNotFoundError:
        raise SimulationError(f"there is no FMU {path}; check the path") from None
    except SimulationError:
        raise
    except Exception as error:
        raise SimulationError(f"{path} is not an FMU that can be read ({_first_reason(error)})") from None


def _first_reason(error: Exception) -> str:
    """Of what an error says; of a description that breaks the standard the first of the list below."""
    problems = error.problems if isinstance(error, ValidationError) else []
    more = f"; and {len(problems) - 1} more" if len(problems) > 1 else ""
    return f"{problems[0].strip()}{more}" if problems else first_line(error)


def require_binary(path: Path) -> None:
    """Raises SimulationError where an FMU has nothing that this machine can run."""
    with zipfile.ZipFile(path) as archive:
        folders = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")} - {""}
    if not {platform, platform_tuple} & folders:
        has = f"binaries for {', '.join(sorted(folders))} only" if folders else "no binaries"
        raise SimulationError(f"{path} has {has}; this machine needs {platform} ({platform_tuple} in FMI 3)")


def continuous_states(description: ModelDescription) -> list[tuple[ScalarVariable, ScalarVariable]]:
    """(state, its derivative) in the order of the model structure."""
    rates = (unknown.variable for unknown in description.derivatives)
    return [(r.derivative, r) for r in rates if r is not None and isinstance(r.derivative, ScalarVariable)]


def first_line(error: Exception) -> str:
    """Of what an error says."""
    return (str(error).strip() or type(error).__name__).splitlines()[0]
