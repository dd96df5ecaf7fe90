"""The tables of a robot file that stand beside the robot: columns, processing, identification, line."""

from flexmodels.files.toml_table import Table, line_of_text
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
    return columns


def _processing(table: Table) -> Processing:
    return Processing(
        derivative=table.get("derivative") if "derivative" in table else None,
        cutoff=table.number("cutoff") if "cutoff" in table else None,
        order=int(table.get("order", 4)),
        decimate=int(table.get("decimate", 1)),
        band=table.number("band") if "band" in table else None,
        dead_zone=table.number("dead_zone", 0.0),
    )


def _identification(table: Table, n: int) -> Identification:
    multisine = table.table("multisine")
    return Identification(
        swing=table.vector("swing", n),
        period=table.number("period"),
        duration=table.number("duration"),
        multisine=Multisine(
            rms=multisine.vector("rms", n),
            lines=int(multisine.get("lines")),
            lowest=multisine.number("lowest"),
            highest=multisine.number("highest"),
        ),
    )


def _line(table: Table, n: int) -> Line:
    locked = tuple(table.whole(k, "locked", 1, n) for k in table.get("locked", ()))
    return Line(
        start=table.vector("start", 3),
        end=table.vector("end", 3),
        duration=table.number("duration"),
        locked=locked,
    )
