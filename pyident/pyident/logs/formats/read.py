"""Any file of a recording -> its columns, by its ending."""

import bz2
import gzip
import lzma
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from pyident.logs.formats.recording import Recording
from pyident.logs.log import LogError, no_log

TEXTS = (".csv", ".txt", ".tsv", ".dat", ".asc")
BAGS = (".mcap", ".bag", ".db3")
OBJECTS = (".json", ".jsonl", ".ndjson")
PACKED = {".gz": gzip.open, ".bz2": bz2.open, ".xz": lzma.open}
ENDINGS = (*TEXTS, ".parquet", ".mat", ".npz", ".h5", ".hdf5", *OBJECTS, *BAGS)


def read_recording(path: Path, header: bool = True, episode: int | None = None) -> Recording:
    """Every numeric column of a file, or of the folder of a bag or a data set. Raises LogError.

    header    False: the first line of a text file is numbers, or its names are not to be used
    episode   of a LeRobot data set
    """
    path = Path(path)
    if not path.exists():
        raise LogError(no_log(path))
    try:
        if path.suffix.lower() in PACKED:
            return _unpacked(path, header, episode)
        return _read(path, header, episode)
    except LogError:
        raise
    except Exception as error:
        what = path.suffix[1:] or "a folder"
        said = (str(error) or type(error).__name__).splitlines()[0]
        raise LogError(f"{path} cannot be read as {what} ({said})") from None


def _unpacked(path: Path, header: bool, episode: int | None) -> Recording:
    """The file within a packed one (`log.csv.gz`), unpacked beside nothing of the user's."""
    with TemporaryDirectory() as folder:
        inside = Path(folder) / path.stem
        with PACKED[path.suffix.lower()](path) as packed, inside.open("wb") as file:
            shutil.copyfileobj(packed, file)
        try:
            return _read(inside, header, episode)
        except LogError as error:
            raise LogError(str(error).replace(str(inside), str(path))) from None


def _read(path: Path, header: bool, episode: int | None) -> Recording:
    ending = path.suffix.lower()
    if path.is_dir() or ending == ".parquet" or path.name == "info.json":
        from pyident.logs.formats.parquet import is_data_set, read_parquet

        root = path.parent.parent if path.name == "info.json" else path
        if root.is_file() or is_data_set(root):
            return read_parquet(root, episode)
        if not (root / "metadata.yaml").is_file():
            raise LogError(
                f"{path} is a folder that holds neither meta/info.json (LeRobot) nor metadata.yaml (ROS 2)"
            )
    if ending in BAGS or path.is_dir():
        from pyident.logs.formats.bags import read_bag

        return read_bag(path)
    if ending in TEXTS:
        from pyident.logs.formats.delimited import read_delimited

        return read_delimited(path, header)
    if ending in OBJECTS:
        from pyident.logs.formats.objects import read_json

        return read_json(path)
    if ending in (".mat", ".npz", ".h5", ".hdf5"):
        from pyident.logs.formats import hierarchical

        readers = {".mat": hierarchical.read_mat, ".npz": hierarchical.read_npz}
        return readers.get(ending, hierarchical.read_hdf5)(path)
    raise LogError(
        f"{path}: a log must end in {', '.join(ENDINGS)}, be one of these packed ({', '.join(PACKED)}), or "
        "the folder of a bag or data set"
    )
