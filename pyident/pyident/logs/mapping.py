"""A mapping file: which of their columns is which of our signals, in which unit, sign and offset."""

import tomllib
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

from flexmodels.files.toml_table import Table, number
from flexmodels.robot import RobotError
from pyident.logs.indices import at_joint, indexed
from pyident.logs.log import LogError
from pyident.logs.units import FACTORS, KINDS, RATED, factor, known_unit


@dataclass(frozen=True)
class Source:
    """One of our signals: gain * column + offset; what it shows at a time was sampled `delay` [s] before.

    column   name in their file (`file:name` where two files share it; `rec.x[2]` for a row of a MAT struct)
    gain, offset   to SI
    clock    column of its own time stamps, in the unit of the mapping's time; None: the mapping's time
    turn     the column's units per turn, where it is an angle that was wrapped to one; else None
    """

    column: str
    gain: float = 1.0
    offset: float = 0.0
    delay: float = 0.0
    clock: str | None = None
    turn: float | None = None


@dataclass(frozen=True)
class Mapping:
    """signals: our name -> Source; header False: columns are 1, 2, ...; rate [Hz] if no time is logged.

    episode   of a LeRobot data set, from 0
    asked     questions (`# ?`) that the file still holds, as `log inspect` writes them
    """

    signals: dict[str, Source]
    header: bool = True
    rate: float | None = None
    episode: int | None = None
    asked: tuple[str, ...] = ()


def read_mapping(path: str | Path) -> Mapping:
    """Read a mapping file (TOML), or one that ships, by its name. Raises LogError.

    The grammar: docs/reference/mapping-file.md.
    """
    ships = shipped_mappings()
    path = ships.get(str(path), Path(path))
    if not path.is_file():
        raise LogError(f"there is no mapping file {path}; check the path (shipped: {', '.join(ships)})")
    try:
        text = path.read_text(encoding="utf-8")
        asked = dict.fromkeys(line for line in text.splitlines() if line.startswith("# ?"))
        return replace(_mapping(Table(tomllib.loads(text), "")), asked=tuple(asked))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: not a TOML file ({error})") from None
    except (RobotError, LogError) as error:
        raise LogError(f"{path}: {error}") from None


def shipped_mappings() -> dict[str, Path]:
    """Name -> file of every mapping that comes with the package, of a data set each."""
    folder = Path(str(resources.files("pyident.logs") / "mappings"))
    return {file.stem: file for file in sorted(folder.glob("*.toml"))}


def _mapping(table: Table) -> Mapping:
    joints = list(range(1, table.whole(table.get("joints", 1), "joints", 1, 1_000) + 1))
    listed = Table(table.get("signals", {}), "signals")
    signals: dict[str, Source] = {}
    for name in listed.data:
        signals |= _signals(listed.table(name), name, joints)
    if "time" in table:
        signals["time"] = _source(table.table("time"), 0, 1)
    rate = table.number("rate", lower=0.0, above=True) if "rate" in table else None
    if (rate is None) == ("time" not in table):
        raise LogError("give either rate [Hz] or time, the column that holds it")
    if not listed.data:
        raise LogError('it maps no column; give each its table, [signals."joint1.e"] with source = "COLUMN"')
    header = table.get("header", True)
    episode = table.whole(table.get("episode"), "episode", 0, 10**6) if "episode" in table else None
    table.done()
    _plausible(signals)
    return Mapping(signals, bool(header), rate, episode)


def _plausible(signals: dict[str, Source]) -> None:
    """Raises LogError where one column is mapped twice, or that of time as something else."""
    owners: dict[str, str] = {}
    for name, source in signals.items():
        other = owners.setdefault(source.column, name)
        if other != name:
            what = " is the column of time and" if "time" in (name, other) else ""
            raise LogError(
                f"column {source.column}{what} is mapped twice, to {other} and to {name}; correct one"
            )


def _signals(table: Table, name: str, joints: list[int]) -> dict[str, Source]:
    if not indexed(name):
        return {name: _source(table, 0, 1, motor=_is_effort(name))}
    if "joints" in table:
        joints = [table.whole(k, "joints", 1, 99) for k in table.get("joints")]
    effort = _is_effort(name)
    return {at_joint(name, k): _source(table, i, len(joints), k, effort) for i, k in enumerate(joints)}


def _is_effort(name: str) -> bool:
    return name.rpartition(".")[2] in ("tau", "tau_ff", "current")


def _source(table: Table, i: int, count: int, k: int = 0, motor: bool = False) -> Source:
    """Of joint k, the i-th of `count`; motor: a torque, which a gear multiplies where it divides an angle."""
    name = known_unit(text := str(table.get("unit", "1"))) or text
    unit = factor(name, table.place("unit"))
    sign, gain, offset, delay, gear = (
        _of_joint(table, key, i, count, default)
        for key, default in (("sign", 1.0), ("gain", 1.0), ("offset", 0.0), ("delay", 0.0), ("gear", 1.0))
    )
    drive = _drive(table, i, count, name, motor)
    if gear == 0:
        raise LogError(f"{table.place('gear')}: a gear must not be 0")
    side = gear if motor else 1 / gear
    clock = at_joint(str(table.get("time")), k) if "time" in table else None
    column = at_joint(str(table.get("source")), k)
    turn = _turn(table, name, motor)
    source = Source(column, sign * gain * drive * side * unit, offset * unit, delay, clock, turn)
    table.done()
    return source


def _turn(table: Table, unit: str, effort: bool) -> float | None:
    """The column's units per turn where it is to be unwrapped, by its unit or as a number; else None."""
    given = table.get("unwrap", False)
    if given is False:
        return None
    if effort or (given is True and KINDS[unit] != "angle"):
        raise LogError(
            f"{table.place('unwrap')}: only an angle is unwrapped; give its unit, or as unwrap the column's "
            "units per turn"
        )
    if given is True:
        return FACTORS["rev"] / FACTORS[unit]
    return number(given, table.place("unwrap"), 0.0, True)


def _drive(table: Table, i: int, count: int, unit: str, effort: bool) -> float:
    """What a torque's column is multiplied by once its unit is: N m per A or V, or what 100 % of it are.

    A column in % or ‰ takes `rated` and no `drive`, which could be meant per unit of it as well as per 100 %.
    """
    if "drive" in table and not effort:
        raise LogError(
            f"{table.place('drive')}: only a torque has a drive (N m per A or V, or per unit of the column)"
        )
    rated = effort and unit in RATED
    if "rated" in table and not rated:
        raise LogError(
            f"{table.place('rated')}: only a torque or current in % or ‰ has a rated value, at 100 %"
        )
    if rated:
        if "drive" in table or "rated" not in table:
            raise LogError(
                f"{table.place('unit')}: a torque in {unit} needs rated = ..., its N m (or N) at 100 %, and "
                f'no drive; or give unit = "1" and as drive the N m per {unit} of the column'
            )
        return _of_joint(table, "rated", i, count, 1.0)
    by_robot = table.where.endswith(".current")  # its transmission makes a torque of it
    if effort and KINDS[unit] == "electric" and "drive" not in table and not by_robot:
        raise LogError(
            f"{table.place('unit')}: a torque that comes in {unit} needs drive = ..., its N m (or N) per "
            f"{'V' if unit.endswith('V') else 'A'}"
        )
    return _of_joint(table, "drive", i, count, 1.0)


def _of_joint(table: Table, key: str, i: int, count: int, default: float) -> float:
    """A number for all joints, or one of a list with a number per joint."""
    value = table.get(key, default)
    if not isinstance(value, list):
        return number(value, table.place(key))
    return table.vector(key, count)[i]
