"""Who made a file, from what and when; two exports of one model are the same bytes."""

import os
import zipfile
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from xml.etree import ElementTree as ET


def _version() -> str:
    try:
        return version("flexident")
    except PackageNotFoundError:
        return "(from its sources)"


TOOL = f"flexident {_version()}"


def sign(root: ET.Element) -> None:
    """Tool and, where SOURCE_DATE_EPOCH gives one, date: the clock's would make every export another file."""
    root.set("generationTool", TOOL)
    moment = os.environ.get("SOURCE_DATE_EPOCH")
    if moment:
        date = datetime.fromtimestamp(float(moment), UTC)
        root.set("generationDateAndTime", date.strftime("%Y-%m-%dT%H:%M:%SZ"))


def zip_folder(folder: Path, path: Path) -> None:
    """Every file of the folder by name, at the oldest date that a ZIP file knows."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for member in sorted(folder.rglob("*")):
            if member.is_file():
                entry = zipfile.ZipInfo(member.relative_to(folder).as_posix(), (1980, 1, 1, 0, 0, 0))
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = (0o755 if "binaries" in entry.filename else 0o644) << 16
                archive.writestr(entry, member.read_bytes())
