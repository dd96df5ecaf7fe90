"""A mapping file: which of their columns is which of our signals, in which unit, sign and offset."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

from flexmodels.files.toml_table import Table, number
from flexmodels.robot import RobotError
from pyident.logs.log import LogError
from pyident.logs.units import factor


@dataclass(frozen=True)
class Source:
    """One of our signals: gain * column + offset, sampled `delay` [s] after its time stamp says.

    column   name in their file (`file:name` where two files share it; `rec.x[2]` for a row of a MAT struct)
    gain, offset   to SI
    """

    column: str
    gain: float = 1.0
    offset: float = 0.0
    delay: float = 0.0


@dataclass(frozen=True)
class Mapping:
    """signals: our name -> Source; header False: columns are 1, 2, ...; rate [Hz] if no time is logged."""

    signals: dict[str, Source]
    header: bool = True
    rate: float | None = None


def read_mapping(path: str | Path) -> Mapping:
    """Read a mapping file (TOML). Raises LogError.

    joints = 6                  what {k} stands for in names: 1 to 6
    rate = 250.0                or time = { source = "t", unit = "ms" }
    header = false              CSV without a line of names: columns are "1", "2", ...
    [signals."joint{k}.e"]      or motor{k}.q, .tau, .current; joint{k}.link, .tau, .r ...
    source = "rec.act_pos_mot_deg[{k}]"
    unit = "deg"; sign = -1; gain = 2.0; offset = [0, -90, 90]; delay = 0.003; joints = [1, 2, 3]
    sign, gain, offset (in `unit`) and delay are one number, or one per joint.
    """
    path = Path(path)
    if not path.is_file():
        raise LogError(f"there is no mapping file {path}; check the path")
    try:
        table = Table(tomllib.loads(path.read_text(encoding="utf-8")), "")
        return _mapping(table)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: not a TOML file ({error})") from None
    except (RobotError, LogError) as error:
        raise LogError(f"{path}: {error}") from None


def _mapping(table: Table) -> Mapping:
    joints = list(range(1, table.whole(table.get("joints", 1), "joints", 1, 1_000) + 1))
    listed = table.table("signals")
    signals: dict[str, Source] = {}
    for name in listed.data:
        signals |= _signals(listed.table(name), name, joints)
    if "time" in table:
        signals["time"] = _source(table.table("time"), 0, 1)
    rate = table.number("rate", lower=0.0, above=True) if "rate" in table else None
    if (rate is None) == ("time" not in table):
        raise LogError("give either rate [Hz] or time, the column that holds it")
    header = table.get("header", True)
    table.done()
    return Mapping(signals, bool(header), rate)


def _signals(table: Table, name: str, joints: list[int]) -> dict[str, Source]:
    if "{k}" not in name:
        return {name: _source(table, 0, 1)}
    if "joints" in table:
        joints = [table.whole(k, "joints", 1, 99) for k in table.get("joints")]
    found = {name.replace("{k}", str(k)): _source(table, i, len(joints), k) for i, k in enumerate(joints)}
    return found


def _source(table: Table, i: int, count: int, k: int = 0) -> Source:
    unit = factor(str(table.get("unit", "1")), table.place("unit"))
    sign, gain, offset, delay = (
        _of_joint(table, key, i, count, default)
        for key, default in (("sign", 1.0), ("gain", 1.0), ("offset", 0.0), ("delay", 0.0))
    )
    source = Source(str(table.get("source")).replace("{k}", str(k)), sign * gain * unit, offset * unit, delay)
    table.done()
    return source


def _of_joint(table: Table, key: str, i: int, count: int, default: float) -> float:
    """A number for all joints, or one of a list with a number per joint."""
    value = table.get(key, default)
    if not isinstance(value, list):
        return number(value, table.place(key))
    return table.vector(key, count)[i]
