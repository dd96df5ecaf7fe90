"""The tables of a robot file that stand beside the robot: columns, processing, identification, line."""

from flexmodels.files.toml_table import Table, line_of_text
from flexmodels.robot import RobotError
from flexmodels.settings.motions import Identification, Line, Multisine
from flexmodels.settings.processing import Column, Processing
from flexmodels.settings.settings import Settings


def read_settings(table: Table, n: int) -> Settings:
    """Of the file's top `table`, for a robot of n driven joints. Raises RobotError."""
    return Settings(
        columns=_columns(table.table("columns")) if "columns" in table else {},
        processing=_processing(table.table("processing")) if "processing" in table else Processing(),
        identification=_identification(table.table("identification"), n)
        if "identification" in table
        else None,
        line=_line(table.table("line"), n) if "line" in table else None,
    )


def _columns(table: Table) -> dict[str, Column]:
    columns = {}
    for signal, value in table.data.items():
        line_of_text(signal, f"{table.where} key")
        if isinstance(value, str):
            columns[signal] = Column(value)
        else:
            entry = Table(value, table.place(signal))
            columns[signal] = Column(entry.text("source"), entry.number("gain", 1.0))
            entry.done()
    return columns


def _processing(table: Table) -> Processing:
    derivative = table.get("derivative") if "derivative" in table else None
    if derivative not in (None, "central", "hat"):
        raise RobotError(f"{table.place('derivative')} must be central or hat, not {derivative!r}")
    processing = Processing(
        derivative=derivative,
        cutoff=table.number("cutoff", lower=0.0, above=True) if "cutoff" in table else None,
        order=table.whole(table.get("order", 4), "order", 1, 20),
        decimate=table.whole(table.get("decimate", 1), "decimate", 1, 1_000_000),
        dead_zone=table.number("dead_zone", 0.0, lower=0.0),
    )
    table.done()
    return processing


def _identification(table: Table, n: int) -> Identification:
    multisine = table.table("multisine")
    experiment = Identification(
        swing=table.vector("swing", n),
        period=table.number("period", lower=0.0, above=True),
        duration=table.number("duration", lower=0.0, above=True),
        multisine=Multisine(
            rms=multisine.vector("rms", n, lower=0.0),
            lines=multisine.whole(multisine.get("lines"), "lines", 1, 100_000),
            lowest=multisine.number("lowest", lower=0.0, above=True),
            highest=multisine.number("highest", lower=0.0, above=True),
        ),
    )
    multisine.done()
    table.done()
    return experiment


def _line(table: Table, n: int) -> Line:
    listed = table.get("locked", ())
    if not isinstance(listed, list | tuple):
        raise RobotError(f"{table.place('locked')} must be a list of joints from 1 to {n}")
    locked = tuple(table.whole(k, "locked", 1, n) for k in listed)
    line = Line(
        start=table.vector("start", 3),
        end=table.vector("end", 3),
        duration=table.number("duration", lower=0.0, above=True),
        locked=locked,
    )
    table.done()
    return line
