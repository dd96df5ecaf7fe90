"""Robot files: TOML in and out. A wrong file gets one sentence that names the key."""

import os
import tempfile
import tomllib
from collections.abc import Mapping
from dataclasses import asdict
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from flexmodels.effects import BASE, CATALOGUE
from flexmodels.robot import (
    Column,
    Controller,
    Identification,
    Joint,
    Line,
    Link,
    Multisine,
    Processing,
    Robot,
    RobotError,
)

_BASE_PARAMETERS = {p.name: effect for effect in BASE.values() for p in effect.parameters}
_PREFIXES = ("stiffness", "damping")  # written as the arrays k and d


def shipped() -> dict[str, Path]:
    """Names and files of the robots that come with the package."""
    folder = Path(str(resources.files("flexmodels") / "robots"))
    return {file.stem: file for file in sorted(folder.glob("*.toml"))}


def load_robot(model: str | Path) -> Robot:
    """A shipped robot by name, or a TOML file by path. Raises RobotError."""
    path = shipped().get(str(model), Path(model))
    if not path.is_file():
        names = ", ".join(shipped())
        raise RobotError(f"unknown robot {str(model)!r}: give a TOML file, or one of {names}")
    try:
        return _robot(tomllib.loads(path.read_text(encoding="utf-8")), path.stem)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise RobotError(f"{path}: not a TOML file ({error})") from None
    except RobotError as error:
        raise RobotError(f"{path}: {error}") from None


def save_robot(robot: Robot, path: str | Path) -> None:
    """Write a robot file: to a temporary file beside it first, then renamed."""
    path = Path(path)
    text = tomli_w.dumps(_document(robot))
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(temporary, path)


class _Table:
    """A TOML table that knows its place, so that every complaint names the key."""

    def __init__(self, data: Any, where: str):
        if not isinstance(data, Mapping):
            raise RobotError(f"{where} must be a table")
        self.data, self.where, self.read = data, where, set()

    def place(self, key: str) -> str:
        return f"{self.where}.{key}" if self.where else key

    def __contains__(self, key: str) -> bool:
        return key in self.data

    def get(self, key: str, default: Any = None) -> Any:
        self.read.add(key)
        if key in self.data:
            return self.data[key]
        if default is None:
            raise RobotError(f"{self.place(key)} is missing")
        return default

    def number(
        self, key: str, default: float | None = None, lower: float = -np.inf, above: bool = False
    ) -> float:
        return _number(self.get(key, default), self.place(key), lower, above)

    def vector(self, key: str, size: int, default: Any = None, lower: float = -np.inf) -> tuple[float, ...]:
        value = self.get(key, default)
        if not isinstance(value, list | tuple) or len(value) != size:
            raise RobotError(f"{self.place(key)} must be {size} numbers")
        return tuple(_number(v, f"{self.place(key)}[{i + 1}]", lower) for i, v in enumerate(value))

    def table(self, key: str) -> "_Table":
        return _Table(self.get(key), self.place(key))

    def tables(self, key: str) -> list["_Table"]:
        value = self.get(key)
        if not isinstance(value, list) or not value:
            raise RobotError(f"{self.place(key)} must be a list of tables ([[{key}]])")
        return [_Table(v, f"{self.place(key)}[{i + 1}]") for i, v in enumerate(value)]

    def done(self) -> None:
        unknown = sorted(set(self.data) - self.read)
        if unknown:
            raise RobotError(f"{self.place(unknown[0])} is not a known key; remove or rename it")


def _number(value: Any, place: str, lower: float = -np.inf, above: bool = False) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise RobotError(f"{place} must be a finite number, not {value!r}")
    if value < lower or (above and value <= lower):
        raise RobotError(f"{place} = {value} must be {'above' if above else 'at least'} {lower:g}")
    return float(value)


def _robot(data: Mapping[str, Any], stem: str) -> Robot:
    table = _Table(data, "")
    joints = tuple(_joint(t) for t in table.tables("joint"))
    links = tuple(_link(t) for t in table.tables("link"))
    if len(links) != len(joints):
        raise RobotError(f"link: {len(joints)} joints need as many links, found {len(links)}")
    controller = _controller(table.table("controller"), len(joints)) if "controller" in table else None
    columns = _columns(table.table("columns")) if "columns" in table else {}
    processing = _processing(table.table("processing")) if "processing" in table else Processing()
    robot = Robot(
        name=str(table.get("name", stem)),
        joints=joints,
        links=links,
        tip=table.vector("tip", 3, (0.0, 0.0, 0.0)),
        gravity=table.vector("gravity", 3, (0.0, 0.0, -9.81)),
        controller=controller,
        columns=columns,
        processing=processing,
        identification=_identification(table.table("identification"), len(joints))
        if "identification" in table
        else None,
        line=_line(table.table("line"), len(joints)) if "line" in table else None,
        description=str(table.get("description", " ")).strip(),
    )
    table.done()
    return robot


def _joint(table: _Table) -> Joint:
    kind = table.get("kind", "revolute")
    if kind not in ("revolute", "prismatic"):
        raise RobotError(f"{table.place('kind')} must be revolute or prismatic, not {kind!r}")
    x, y = table.vector("x", 3), table.vector("y", 3)
    if abs(np.linalg.norm(x) - 1) > 1e-9 or abs(np.linalg.norm(y) - 1) > 1e-9 or abs(np.dot(x, y)) > 1e-9:
        raise RobotError(f"{table.place('x')} and y must be unit vectors at right angles")
    values = _laws(table)
    joint = Joint(
        kind=kind,
        x=x,
        y=y,
        origin=table.vector("origin", 3, (0.0, 0.0, 0.0)),
        flexible="stiffness" in values,
        values=values,
    )
    if "damping" in values and not joint.flexible:
        raise RobotError(f"{table.place('d')} needs {table.place('k')}")
    table.done()
    return joint


def _laws(table: _Table) -> dict[str, dict[str, float]]:
    values: dict[str, dict[str, float]] = {}
    for key, effect in (("k", "stiffness"), ("d", "damping")):
        if key in table:
            numbers = table.vector(key, 3, lower=0.0)
            values[effect] = {f"{key}[{i + 1}]": v for i, v in enumerate(numbers)}
    for name, effect in _BASE_PARAMETERS.items():
        if name in table:
            lower = effect.parameters[0].lower
            values.setdefault(effect.name, {})[name] = table.number(name, lower=lower)
    if "effects" in table:
        effects = table.table("effects")
        for name in effects.data:
            values[name] = _effect_values(effects, name)
    return values


def _effect_values(effects: _Table, name: str) -> dict[str, float]:
    if name not in CATALOGUE or name in BASE:
        known = ", ".join(sorted(set(CATALOGUE) - set(BASE)))
        raise RobotError(f"{effects.place(name)} is not a known effect; known are {known}")
    table = effects.table(name)
    values = {p.name: table.number(p.name, lower=p.lower) for p in CATALOGUE[name].parameters}
    table.done()
    return values


def _link(table: _Table) -> Link:
    m = table.number("m", lower=0.0)
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
    table.done()
    return link


def _symmetric(J: tuple[float, ...]) -> np.ndarray:
    if len(J) == 3:
        return np.diag(J)
    xx, xy, xz, yy, yz, zz = J
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _controller(table: _Table, n: int) -> Controller:
    controller = Controller(
        rate=table.number("rate", lower=0.0, above=True),
        Kp=table.vector("Kp", n),
        Kd=table.vector("Kd", n),
        Ki=table.vector("Ki", n),
    )
    table.done()
    return controller


def _columns(table: _Table) -> dict[str, Column]:
    columns = {}
    for signal, value in table.data.items():
        if isinstance(value, str):
            columns[signal] = Column(value)
        else:
            entry = _Table(value, table.place(signal))
            columns[signal] = Column(str(entry.get("source")), entry.number("gain", 1.0))
            entry.done()
    return columns


def _processing(table: _Table) -> Processing:
    decimate = table.number("decimate", 1, lower=1)
    derivative = table.get("derivative") if "derivative" in table else None
    if derivative not in (None, "central", "hat"):
        raise RobotError(f"{table.place('derivative')} must be central or hat, not {derivative!r}")
    processing = Processing(
        derivative=derivative,
        cutoff=table.number("cutoff", lower=0.0, above=True) if "cutoff" in table else None,
        order=int(table.number("order", 4, lower=1)),
        decimate=int(decimate),
    )
    table.done()
    return processing


def _identification(table: _Table, n: int) -> Identification:
    multisine = table.table("multisine")
    experiment = Identification(
        swing=table.vector("swing", n),
        period=table.number("period", lower=0.0, above=True),
        duration=table.number("duration", lower=0.0, above=True),
        multisine=Multisine(
            rms=multisine.vector("rms", n, lower=0.0),
            lines=int(multisine.number("lines", lower=1)),
            lowest=multisine.number("lowest", lower=0.0, above=True),
            highest=multisine.number("highest", lower=0.0, above=True),
        ),
    )
    multisine.done()
    table.done()
    return experiment


def _line(table: _Table, n: int) -> Line:
    locked = tuple(int(k) for k in table.get("locked", ()))
    if any(not 1 <= k <= n for k in locked):
        raise RobotError(f"{table.place('locked')} must name joints from 1 to {n}")
    line = Line(
        start=table.vector("start", 3),
        end=table.vector("end", 3),
        duration=table.number("duration", lower=0.0, above=True),
        locked=locked,
    )
    table.done()
    return line


def _document(robot: Robot) -> dict[str, Any]:
    document: dict[str, Any] = {
        "name": robot.name,
        "description": robot.description,
        "gravity": list(robot.gravity),
        "tip": list(robot.tip),
    }
    if robot.controller:
        c = robot.controller
        document["controller"] = {"rate": c.rate, "Kp": list(c.Kp), "Kd": list(c.Kd), "Ki": list(c.Ki)}
    if robot.columns:
        document["columns"] = {
            s: c.source if c.gain == 1 else {"source": c.source, "gain": c.gain}
            for s, c in robot.columns.items()
        }
    if robot.processing != Processing():
        p = robot.processing
        document["processing"] = {key: v for key, v in asdict(p).items() if v is not None}
    if robot.identification:
        document["identification"] = _plain(asdict(robot.identification))
    if robot.line:
        document["line"] = _plain(asdict(robot.line))
    document["joint"] = [_joint_document(joint) for joint in robot.joints]
    document["link"] = [{"m": link.m, "ms": list(link.ms), "J": list(link.J)} for link in robot.links]
    return document


def _plain(value: Any) -> Any:
    """Tuples as lists, for TOML."""
    if isinstance(value, dict):
        return {key: _plain(v) for key, v in value.items()}
    return list(value) if isinstance(value, tuple) else value


def _joint_document(joint: Joint) -> dict[str, Any]:
    table: dict[str, Any] = {
        "kind": joint.kind,
        "origin": list(joint.origin),
        "x": list(joint.x),
        "y": list(joint.y),
    }
    others = {}
    for effect, values in joint.values.items():
        if effect in _PREFIXES:
            table[next(iter(values))[0]] = list(values.values())
        elif effect in BASE:
            table |= values
        else:
            others[effect] = dict(values)
    if others:
        table["effects"] = others
    return table
