"""Public measurements of real robots by name, checked by SHA-256: from PYIDENT_DATA or their repositories."""

import os
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from pyident.logs.log import LogError

_RAW = "https://raw.githubusercontent.com"


@dataclass(frozen=True)
class Recording:
    """A file of a data set: its place in the set's folder, in the repository, and its SHA-256."""

    here: str
    there: str
    sha256: str


@dataclass(frozen=True)
class DataSet:
    """title and licence in words; repository `owner/name` at a commit; files."""

    title: str
    licence: str
    repository: str
    commit: str
    files: tuple[Recording, ...]


DATA_SETS = {
    "emps": DataSet(
        "EMPS, a prismatic axis (Janot, Gautier and Brunot 2019)",
        "public benchmark, nonlinearbenchmark.org; cite the authors",
        "forgi86/sysid-neural-continuous",
        "956aa7ec",
        (
            Recording(
                "DATA_EMPS.mat",
                "examples/EMPS/data/DATA_EMPS.mat",
                "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e",
            ),
        ),
    ),
    "tx40": DataSet(
        "Staubli TX40, six axes, motor angles and torques",
        "Apache-2.0",
        "thanhndv212/figaroh-plus",
        "c3b51728",
        (
            Recording(
                "pos_read_data.csv",
                "examples/staubli_TX40/data/pos_read_data.csv",
                "5cc1cecc1024ef0e331d0caba06f689456ab789ec3f1e904599c0a8be5c27bc8",
            ),
            Recording(
                "curr_data.csv",
                "examples/staubli_TX40/data/curr_data.csv",
                "f4592f4ba4db42f5d7625688986be25b575ca34d0504b27979ca6b0276bd3af9",
            ),
        ),
    ),
    "kuka_kr300": DataSet(
        "KUKA KR300 R2500 ultra SE, link encoders on axes 1 to 3, runs A and B",
        "MIT",
        "JonasWeigand/Robot_Identification",
        "9e403c07",
        (
            Recording(
                "A/data.mat",
                "data/recorded_trajectories/2020-10-21 10s FF A 08ms/data.mat",
                "4c152c5b7f2c899731fdeebcf0d011cc103df72be19fac160caf47aa9b73ab75",
            ),
            Recording(
                "B/data.mat",
                "data/recorded_trajectories/2020-10-21 10s FF B 08ms/data.mat",
                "edeb35f65c4ec4bb697e757fc1e4e9668551b6fe7b2c3dbbb526d040dd8d5ce7",
            ),
        ),
    ),
}


def fetch(name: str, download: bool = True) -> list[Path]:
    """The files of a data set, in its order: from the folder PYIDENT_DATA, else from cache or network.

    Raises LogError for an unknown name, for a file that is not what it should be, and where there is none.
    """
    if name not in DATA_SETS:
        raise LogError(f"there is no data set {name}; there are {', '.join(DATA_SETS)}")
    found = DATA_SETS[name]
    return [_local(name, file) or _remote(name, found, file, download) for file in found.files]


def _local(name: str, file: Recording) -> Path | None:
    folder = os.environ.get("PYIDENT_DATA")
    path = Path(folder) / name / file.here if folder else None
    if path is None or not path.is_file():
        return None
    import pooch

    if pooch.file_hash(str(path)) != file.sha256:
        raise LogError(f"{path} is not the file of data set {name} (its SHA-256 differs); fetch it again")
    return path


def _remote(name: str, found: DataSet, file: Recording, download: bool) -> Path:
    import pooch
    import requests

    folder = Path(pooch.os_cache("flexident")) / name
    if not download and not (folder / file.here).is_file():
        raise LogError(f"data set {name} is not on this machine; run: pyident data fetch {name}")
    url = f"{_RAW}/{found.repository}/{found.commit}/{quote(file.there)}"
    try:
        (folder / file.here).parent.mkdir(parents=True, exist_ok=True)
        return Path(pooch.retrieve(url, f"sha256:{file.sha256}", fname=file.here, path=folder))
    except (requests.RequestException, ValueError) as error:
        reason = str(error).splitlines()[0][:200]
        raise LogError(
            f"{url} cannot be fetched ({reason}); or set PYIDENT_DATA to a folder with {name}"
        ) from None
