"""Robots from and to other people's files, and all that a model is handed on with."""

from collections.abc import Iterable
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

from flexmodels.atomic import replacing
from flexmodels.files.formats import exported, imported
from flexmodels.files.robot_file import check_readable, robot_text, save_robot
from pyident.verbs.inputs import Model, robot_of
from pyident.verbs.simulate import Progress, export_fmu

_FILES = (".fmu", ".ssp")


def import_robot(
    file: str | Path,
    output: str | Path,
    *,
    flexible: Iterable[int] = (),
    twist: Iterable[int] = (),
    fixed: Iterable[str] = (),
) -> tuple[str, ...]:
    """Write the robot of a URDF or MJCF as a robot file; what of the file it does not hold, a sentence each.

    flexible, twist   joints (from 1) that twist and bend, or only twist
    fixed             names of a URDF's joints that stand still, such as a gripper's
    Raises RobotError.
    """
    robot, notes = imported(file, flexible, twist, fixed)
    check_readable(robot)
    save_robot(robot, output)
    return notes


def export_robot(model: Model, path: str | Path) -> tuple[str, ...]:
    """Write a robot as URDF, MJCF (.xml) or five numbers per joint (.json); what the file cannot say.

    Raises RobotError.
    """
    notes, _ = exported(robot_of(model), path)
    return tuple(notes)


def bundle(model: Model, path: str | Path, script: str = "", progress: Progress | None = None) -> Path:
    """A zip with the robot as TOML, URDF, MJCF, FMU (FMI 2 and 3) and SSP, and a script; its path.

    What a format cannot say, or why a file is left out, stands in NOTES.txt. Raises RobotError.
    """
    from tempfile import TemporaryDirectory

    robot = robot_of(model)
    notes: list[str] = []
    with TemporaryDirectory() as folder:
        names = [f"{robot.name}{ending}" for ending in (".urdf", ".xml", ".fmu", "_fmi3.fmu", ".ssp")]
        for i, name in enumerate(names, start=1):
            notes += _written(robot, Path(folder) / name)
            if progress:
                progress(i / len(names))
        with replacing(path) as file, ZipFile(file, "w", ZIP_DEFLATED) as packed:
            packed.writestr(f"{robot.name}.toml", robot_text(robot))
            packed.writestr("replay.sh", script)
            packed.writestr("NOTES.txt", "\n".join(notes) + "\n")
            for made in sorted(Path(folder).iterdir()):
                packed.write(made, made.name)
    return Path(path)


def _written(robot: Model, path: Path) -> list[str]:
    """Write one file; what it leaves out of the robot, or why there is none."""
    try:
        if path.suffix in _FILES:
            export_fmu(robot, path, 3 if path.stem.endswith("_fmi3") else 2)
            return []
        return [f"{path.name}: {note}" for note in export_robot(robot, path)]
    except (ValueError, RuntimeError) as error:
        path.unlink(missing_ok=True)
        return [f"{path.name} is left out: {error}"]
