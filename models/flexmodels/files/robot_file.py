"""Robot files: TOML in and out. A wrong file gets one sentence that names the key."""

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from flexmodels.atomic import replacing
from flexmodels.effects import effects_of
from flexmodels.effects.law_names import EffectError
from flexmodels.effects.trust import allowed_file
from flexmodels.files.effect_copies import effects_beside
from flexmodels.files.joint_tables import read_closures, read_joints, require_order
from flexmodels.files.robot_document import document
from flexmodels.files.schema import schema
from flexmodels.files.servo_table import read_servo
from flexmodels.files.settings_tables import read_settings
from flexmodels.files.toml_table import Table, line_of_text, number, read_toml
from flexmodels.files.urdf.check import require_few
from flexmodels.files.validate import validate
from flexmodels.gearing import Transmission
from flexmodels.link import Link
from flexmodels.loops.linkage_check import check_linkage
from flexmodels.robot import Robot, RobotError
from flexmodels.settings.controller import Controller

_BEGINNING = 1000  # characters in which a file shows what it is


def shipped() -> dict[str, Path]:
    """Names and files of the robots that come with the package."""
    folder = Path(str(resources.files("flexmodels") / "robots"))
    return {file.stem: file for file in sorted(folder.glob("*.toml"))}


def load_robot(model: str | Path, allow_effects: bool = False) -> Robot:
    """The robot that `model` names: one that ships, or a TOML file by its path. Raises RobotError.

    allow_effects   run the Python files that its `effects` names; without it only those that are trusted
    """
    path = shipped().get(str(model), Path(model))
    if not path.is_file():
        names = ", ".join(shipped())
        if path.suffix == ".toml":
            raise RobotError(f"there is no robot file {path}; check the path (robots that ship: {names})")
        raise RobotError(f"unknown robot {str(model)!r}: give a TOML file, or one of {names}")
    if _is_xml(path):
        own = path.with_suffix(".toml").name
        raise RobotError(f"{path} is no robot file yet: pyident robots import {path.name} -o {own} makes one")
    content = read_toml(path)
    try:
        return _robot(content, path, allow_effects)
    except (RobotError, EffectError) as error:
        raise RobotError(f"{path}: {error}") from None


def _is_xml(path: Path) -> bool:
    """Whether it begins like a URDF or MJCF."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        return file.read(_BEGINNING).lstrip().startswith("<")


def check_readable(robot: Robot) -> None:
    """Raises RobotError unless a file of this robot could be loaded."""
    text = tomli_w.dumps(document(replace(robot, effect_files=()), {}))
    try:
        _robot(tomllib.loads(text), Path("robot.toml"), allow_effects=False)
    except ValueError as error:
        raise RobotError(f"robot {robot.name} cannot be used: {error}") from None


def save_robot(robot: Robot, path: str | Path) -> None:
    """Write a robot file at `path`, beside it copies of effect files from elsewhere. Raises RobotError."""
    folder = Path(path).resolve().parent
    beside = {file: effects_beside(file, folder) for file in robot.effect_files}
    with replacing(path) as file:
        file.write_text(tomli_w.dumps(document(robot, beside)), encoding="utf-8")


def robot_text(robot: Robot) -> str:
    """What `save_robot` writes, effect files by their bare names."""
    return tomli_w.dumps(document(robot, {file: Path(file).name for file in robot.effect_files}))


def _robot(data: Mapping[str, Any], path: Path, allow_effects: bool) -> Robot:
    table = Table(data, "")
    effect_files = _effect_files(table, path, allow_effects) if "effects" in table else ()
    own = effects_of(effect_files)
    require_order(data)
    validate(data, schema(own))
    joints, passive = read_joints(table.tables("joint"), own)
    require_few(len(joints))
    links = tuple(_link(t) for t in table.tables("link"))
    count = len(joints) + len(passive)
    if len(links) != count:
        raise RobotError(f"link: {count} joints need as many links, found {len(links)}")
    controller = _controller(table.table("controller"), len(joints)) if "controller" in table else None
    servo = read_servo(table.table("servo"), len(joints)) if "servo" in table else None
    if controller and servo:
        raise RobotError("servo and controller both drive the joints; keep one of them")
    robot = Robot(
        name=table.text("name", path.stem),
        joints=joints,
        links=links,
        tip=table.vector("tip", 3, (0.0, 0.0, 0.0)),
        gravity=table.vector("gravity", 3, (0.0, 0.0, -9.81)),
        controller=controller,
        servo=servo,
        settings=read_settings(table, len(joints)),
        description=_description(table),
        passive=passive,
        closures=read_closures(table.tables("closure"), count) if "closure" in table else (),
        transmission=_transmission(table.table("transmission"), len(joints))
        if "transmission" in table
        else None,
        tip_link=table.whole(table.get("tip_link"), "tip_link", 1, count) if "tip_link" in table else None,
        effect_files=effect_files,
    )
    check_linkage(robot)
    return robot


def _description(table: Table) -> str:
    """Several lines become one."""
    given = table.get("description", "")
    return line_of_text(" ".join(given.split()) if isinstance(given, str) else given, "description")


def _effect_files(table: Table, path: Path, allow: bool) -> tuple[str, ...]:
    """Absolute paths of the listed files, which stand beside the robot file and may run."""
    listed = table.get("effects")
    if not isinstance(listed, list) or not all(isinstance(name, str) for name in listed):
        raise RobotError("effects must be a list of Python files")
    allowed = [
        allowed_file(name, path.parent, "--allow-effects (allow_effects=True)", allow) for name in listed
    ]
    return tuple(map(str, allowed))


def _link(table: Table) -> Link:
    m = table.number("m")
    if "com" in table:
        com = np.array(table.vector("com", 3))
        J = table.get("J_com")
        size = 3 if isinstance(J, list) and len(J) == 3 else 6
        J_com = _symmetric(table.vector("J_com", size))
        link = Link.of_centre(m, com, J_com)
    else:
        link = Link(m, table.vector("ms", 3), table.vector("J", 6))
    if np.linalg.eigvalsh(_symmetric(link.J)).min() < -1e-9 * max(np.abs(link.J)):
        raise RobotError(f"{table.where}: the inertia has a negative principal value")
    return link


def _symmetric(J: tuple[float, ...]) -> np.ndarray:
    if len(J) == 3:
        return np.diag(J)
    xx, xy, xz, yy, yz, zz = J
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _controller(table: Table, n: int) -> Controller:
    return Controller(
        rate=table.number("rate"),
        Kp=table.vector("Kp", n),
        Kd=table.vector("Kd", n),
        Ki=table.vector("Ki", n),
    )


def _transmission(table: Table, n: int) -> Transmission:
    """ratio: a number per joint, or the rows of a matrix."""
    rows = table.get("ratio")
    if isinstance(rows, list) and rows and isinstance(rows[0], list):
        if len(rows) != n or any(not isinstance(row, list) or len(row) != n for row in rows):
            raise RobotError(f"{table.place('ratio')} must be {n} rows of {n} numbers, or {n} numbers")
        places = [f"{table.place('ratio')}[{i + 1}]" for i in range(n)]
        ratio = [[number(v, place) for v in row] for row, place in zip(rows, places, strict=True)]
    else:
        ratio = np.diag(table.vector("ratio", n)).tolist()
    if np.linalg.matrix_rank(ratio) < n:
        raise RobotError(f"{table.place('ratio')} cannot be inverted; every joint needs its motor")
    return Transmission(
        ratio=tuple(tuple(row) for row in ratio),
        offset=table.vector("offset", n, (0.0,) * n),
        drive=table.vector("drive", n) if "drive" in table else None,
    )
