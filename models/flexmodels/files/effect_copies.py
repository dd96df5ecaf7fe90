"""Files of effects travel with the robot file that names them: only files beside it may run."""

from pathlib import Path

from flexmodels.atomic import replacing
from flexmodels.robot import RobotError


def effects_beside(file: str, folder: Path) -> str:
    """Name of an effect file as seen from `folder`, copied there from elsewhere. Raises RobotError."""
    source = Path(file).resolve()
    if source.is_relative_to(folder):
        return source.relative_to(folder).as_posix()
    content, copy = source.read_bytes(), folder / source.name
    if copy.exists() and copy.read_bytes() != content:
        raise RobotError(
            f"{copy} exists and is not the {source.name} of this robot, which must stand beside it; "
            "move one of them, or write the robot to another folder"
        )
    if not copy.exists():
        with replacing(copy) as temporary:
            temporary.write_bytes(content)
    return copy.name
