"""The columns of one table of rows, put under the joints, the stamps and the clocks that its words tell."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from pyident.logs.formats.interleaved import with_own_clocks
from pyident.logs.formats.joint_rows import by_joint
from pyident.logs.formats.joint_states import with_joint_names
from pyident.logs.formats.recording import Recording, with_whole_stamps
from pyident.logs.log import LogError


def recording_of(
    columns: Mapping[str, np.ndarray],
    texts: Mapping[str, pd.Series],
    where: str,
    units: Mapping[str, str] | None = None,
    header: bool = True,
    notes: Sequence[str] = (),
) -> Recording:
    """Stamps in two columns as one, messages and rows of joints under their joint, several sources apart.

    columns, texts   columns of numbers (N,) and of words, row by row
    where            the file, for errors
    Raises LogError where there is no number, or where rows contradict each other.
    """
    units = units or {}
    columns, left = with_joint_names(with_whole_stamps(columns), texts)
    if not columns:
        raise LogError(f"{where} holds no column of numbers")
    split = by_joint(columns, {name: texts[name] for name in left}, where)
    if split is not None:
        own = {n: u for n in split.columns for name, u in units.items() if f".{n}".endswith(f".{name}")}
        return replace(split, units=own, header=header, notes=(*notes, *split.notes))
    columns, clocks = with_own_clocks(columns)
    return Recording(columns, units, clocks, header, tuple(notes), tuple(left))
