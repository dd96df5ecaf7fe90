"""What the cells of a table of text hold: numbers, lists of numbers, dates and times of the day."""

import re

import numpy as np
import pandas as pd

from pyident.logs.units import known_unit

NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*|\s*(nan|inf|-inf)\s*", re.IGNORECASE)
COMMA = re.compile(r"\s*[-+]?(\d{1,3}(\.\d{3})+,\d*|\d+,?\d*|,\d+)([eE][-+]?\d+)?\s*")
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(\.\d{3})+(,\d*)?")  # 1.234,56
_DAY = r"\d{4}[-/.]\d\d[-/.]\d\d|\d{1,2}[./]\d{1,2}[./]\d{4}"
_DATE = re.compile(rf"\s*({_DAY}),?[T ]\s*\d\d?:\d\d.*")
_OF_THE_DAY = re.compile(r"\s*\d{1,2}:\d\d:\d\d([.,]\d+)?\s*")
_LIST = re.compile(r"\s*(?:array\(\s*(?:'\w'\s*,\s*)?)?([\[(].*[\])])\s*", re.DOTALL)  # array('d', [1.0])
_TYPE = re.compile(r",\s*dtype=\w+|\b(?:np|numpy)\.\w+(?=\()")  # as NumPy writes its own numbers
_FORMATS = (
    "ISO8601",
    *(f"{day} %H:%M:%S{part}" for day in ("%d.%m.%Y", "%m/%d/%Y", "%d/%m/%Y") for part in (".%f", "")),
    "mixed",
)
_SECONDS_OF_A_DAY = 86400.0


def is_list(cell: str) -> bool:
    """Whether it is a list, of numbers or names, and not a unit in brackets."""
    if not _LIST.fullmatch(cell) or known_unit(cell) is not None:
        return False
    parts = list_parts(cell)
    return any(map(NUMBER.fullmatch, parts)) or (len(parts) > 1 and any(c in cell for c in "'\","))


def is_stamp(cell: str) -> bool:
    """Whether it is a date with a time, or a time of the day."""
    return bool(_DATE.fullmatch(cell) or _OF_THE_DAY.fullmatch(cell))


def list_parts(cell: str) -> list[str]:
    """The members of a list as Python, JSON, NumPy and spreadsheets write it."""
    found = _LIST.fullmatch(cell)
    inside = _TYPE.sub("", found[1] if found else cell)
    return [part.strip("'\"") for part in re.split(r"[\s,;\[\]()]+", inside) if part.strip("'\"")]


def numbers_of(name: str, column: pd.Series, joints: list[str], decimal: str) -> dict[str, np.ndarray]:
    """A column's numbers (N,); of lists a column per place, or per joint; of dates seconds; else nothing."""
    if pd.api.types.is_bool_dtype(column) or pd.api.types.is_numeric_dtype(column):
        return {name: column.to_numpy(float)}
    text = column.astype(str).str.strip()
    if sum(map(is_list, text)) > 0.9 * len(text):
        return _lists(name, text, joints)
    plain = with_points(text, decimal)
    numbers = np.asarray(pd.to_numeric(plain, errors="coerce"), float)
    if np.isfinite(numbers).mean() > 0.5:
        return {name: numbers}
    seconds = _seconds(text) if len(text) and is_stamp(text.iloc[0]) else None
    return {} if seconds is None else {name: seconds}


def with_points(text: pd.Series, decimal: str) -> pd.Series:
    """Numbers with the decimal sign of a table as others write them, without points between thousands where
    the column has numbers with both signs.
    """
    if decimal == ",":
        grouped = text.str.fullmatch(_THOUSANDS)
        if (grouped & text.str.contains(",", regex=False)).any():
            text = text.where(~grouped, text.str.replace(".", "", regex=False))
    return text.str.replace(decimal, ".", regex=False)


def _lists(name: str, text: pd.Series, joints: list[str]) -> dict[str, np.ndarray]:
    rows = [list_parts(cell) for cell in text]
    if len({len(row) for row in rows}) > 1 or not all(map(NUMBER.fullmatch, rows[0])):
        return {}
    named = len(rows[0]) == len(joints)
    places = range(1, len(rows[0]) + 1)
    ends = [f"{joint}.{name}" for joint in joints] if named else [f"{name}[{i}]" for i in places]
    values = np.array([[float(part) for part in row] for row in rows])
    return dict(zip(ends, values.T, strict=True))


def _seconds(text: pd.Series) -> np.ndarray | None:
    """Dates (N,) or times of the day, over midnight too, in seconds from the first on."""
    text = text.str.replace(",", ".", regex=False)
    if text.map(lambda cell: bool(_OF_THE_DAY.fullmatch(cell))).all():
        of_day = pd.to_timedelta(text).dt.total_seconds().to_numpy(float)
        return np.unwrap(of_day - of_day[0], period=_SECONDS_OF_A_DAY)
    for style in _FORMATS:
        try:
            stamps = pd.to_datetime(text, errors="raise", utc=True, format=style)
        except (ValueError, TypeError):
            continue
        return (stamps - stamps.iloc[0]).dt.total_seconds().to_numpy(float)
    return None
