"""MAT, NumPy and HDF5 files: variables, structs, groups; MAT 7.3 is HDF5 and needs the extra `hdf5`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pyident.logs.formats.recording import Recording, leaves
from pyident.logs.log import LogError
from pyident.logs.units import known_unit

_TIMES = ("time", "timestamp", "timestamps", "t", "stamp")


def read_mat(path: Path) -> Recording:
    """Vectors of a MAT file by variable, struct field and row of a matrix. Raises LogError."""
    from scipy.io import loadmat

    try:
        content = loadmat(path, squeeze_me=True)
    except NotImplementedError:
        return read_hdf5(path, separator=".")
    if "columns" in content and "c0" in content:
        names = [str(name) for name in np.atleast_1d(content["columns"])]
        return Recording({name: content[f"c{i}"] for i, name in enumerate(names)})
    columns = {
        name: x for key in content if not key.startswith("__") for name, x in leaves(key, content[key])
    }
    return _long(path, columns, {})


def read_npz(path: Path) -> Recording:
    """Arrays of a NumPy archive by name, field and row of a matrix. Raises LogError."""
    with np.load(path, allow_pickle=False) as file:
        columns = {name: x for key in file.files for name, x in _fields(key, _squeezed(file[key]))}
    return _long(path, columns, {})


def read_hdf5(path: Path, separator: str = "/") -> Recording:
    """Vectors of the data sets; an attribute `unit` or `units` is kept. Raises LogError."""
    try:
        import h5py
    except ImportError:
        raise LogError(f"{path}: this file needs the extra: pip install 'flexident[hdf5]'") from None
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("#"):
            return
        place = name.replace("/", separator)
        found = list(_fields(place, _squeezed(item[()]), separator))
        columns.update(found)
        for key in ("unit", "units"):
            if key in item.attrs and (unit := known_unit(_text(item.attrs[key]))):
                units.update({leaf: unit for leaf, _ in found})

    with h5py.File(path) as file:
        file.visititems(visit)
    return _long(path, columns, units)


def _long(path: Path, columns: dict[str, np.ndarray], units: dict[str, str]) -> Recording:
    """Without single numbers and short vectors; columns beside a time of their own length get it as clock."""
    lengths = {name: len(x) for name, x in columns.items()}
    least = max(2, 0.02 * max(lengths.values(), default=0))
    kept = {name: x.astype(float) for name, x in columns.items() if len(x) >= least}
    if not kept:
        raise LogError(f"{path} holds no numeric vectors")
    clocks: dict[str, str] = {}
    if len({len(x) for x in kept.values()}) > 1:
        times = [name for name in kept if _last(name).lower() in _TIMES]
        for name, x in kept.items():
            beside = [t for t in times if t != name and len(kept[t]) == len(x)]
            near = [t for t in beside if _place(t) == _place(name)] or beside
            if name not in times and near:
                clocks[name] = near[0]
    return Recording(kept, units, clocks)


def _fields(name: str, table: np.ndarray, separator: str = ".") -> Iterator[tuple[str, np.ndarray]]:
    """Vectors of an array, or of the fields of a table of records."""
    if not table.dtype.names:
        yield from leaves(name, table)
    for part in table.dtype.names or ():
        yield from leaves(f"{name}{separator}{part}", table[part])


def _last(name: str) -> str:
    return name.replace("/", ".").rsplit(".", 1)[-1]


def _place(name: str) -> str:
    return name[: len(name) - len(_last(name))]


def _squeezed(values: Any) -> Any:
    values = np.asarray(values)
    return values.squeeze() if values.ndim > 1 and 1 in values.shape else values


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)
