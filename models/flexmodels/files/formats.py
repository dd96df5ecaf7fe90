"""Other people's robot formats by the ending or the content of a file."""

from collections.abc import Iterable
from pathlib import Path

from flexmodels.robot import Robot, RobotError


def imported(
    path: str | Path, flexible: Iterable[int] = (), twist: Iterable[int] = (), fixed: Iterable[str] = ()
) -> tuple[Robot, tuple[str, ...]]:
    """The robot of a URDF or MJCF file, and what of the file it does not hold.

    flexible, twist   joints (from 1) that twist and bend, or only twist
    fixed             names of a URDF's joints that stand still
    Raises RobotError.
    """
    from flexmodels.files.mjcf.importer import import_mjcf
    from flexmodels.files.urdf.importer import import_urdf

    still = list(fixed)
    if is_mjcf(path):
        if still:
            raise RobotError(f"{path}: no joint of an MJCF is fixed here; take {still[0]} out of the file")
        read = import_mjcf(path, flexible, twist)
        return read.robot, read.notes
    return import_urdf(path, flexible, twist, still), ()


def is_mjcf(path: str | Path) -> bool:
    """By the root element: both formats may end in .xml."""
    file = Path(path)
    if not file.is_file():
        return file.suffix == ".xml"
    return "<mujoco" in file.read_text(encoding="utf-8", errors="replace")


def exported(robot: Robot, path: str | Path) -> tuple[list[str], frozenset[str]]:
    """Write .urdf, .xml (MJCF) or .json (five numbers per joint).

    Returns what the format cannot say, a sentence each, and the names of the laws that it keeps. Raises
    RobotError.
    """
    from flexmodels.files import five_numbers
    from flexmodels.files.mjcf import exporter as mjcf
    from flexmodels.files.urdf import exporter as urdf

    formats = {
        ".urdf": (urdf.export_urdf, urdf.KEPT),
        ".xml": (mjcf.export_mjcf, mjcf.KEPT),
        ".json": (five_numbers.export_five_numbers, five_numbers.KEPT),
    }
    ending = Path(path).suffix
    if ending not in formats:
        raise RobotError(f"{path}: a robot is written as {', '.join(formats)}; give the file such an ending")
    write, kept = formats[ending]
    return write(robot, path), kept
