"""The parts of an FMU -> the file: sources, binaries, descriptions, documentation, a recorded run."""

import shutil
import warnings
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from flexfmu import fmi2_description, fmi3_description
from flexfmu.compilation import HOST, PLATFORMS, compile_for
from flexfmu.interface import Interface
from flexfmu.simulate import constant_run
from flexfmu.source import RUNTIME, token_of
from flexmodels.atomic import replacing
from flexmodels.inputs import SimulationError
from flexmodels.scratch import scratch_folder

Version = Literal[2, 3]
Platforms = Literal["host", "all"]
_SAMPLES = 50  # of the recorded run
_BUILD_DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="{identifier}">
    <SourceFileSet language="C99">
{files}
      <PreprocessorDefinition name="FMI3_OVERRIDE_FUNCTION_PREFIX"/>
    </SourceFileSet>
    <Library name="m"/>
  </BuildConfiguration>
</fmiBuildDescription>
"""


@dataclass(frozen=True)
class Package:
    """All that goes into one FMU.

    runtime    names of the runtime's C files, beside the face and the instance
    sources    generated C files: name -> text
    page       documentation/index.html
    icons      name -> content, `icon.png` and `icon.svg`
    push       constant inputs of the recorded run
    """

    interface: Interface
    runtime: tuple[str, ...]
    sources: dict[str, str]
    derivatives: bool
    page: str
    icons: dict[str, bytes]
    push: dict[str, float]


def write_fmu(package: Package, path: str | Path, fmi: Version, platforms: Platforms) -> Path:
    """Compile, describe, record, zip. Raises BuildError."""
    path, identifier = Path(path), package.interface.identifier
    with scratch_folder() as folder:
        root = folder
        names = _write_sources(root / "sources", package, f"fmi{fmi}")
        for platform in PLATFORMS if platforms == "all" else [HOST]:
            binary = root / "binaries" / platform.folder(fmi) / f"{identifier}{platform.suffix}"
            binary.parent.mkdir(parents=True)
            compile_for(platform, root / "sources", names, binary, native=platforms == "host")
        _describe(root, package, names, fmi)
        _document(root / "documentation", package)
        _record(root, package)
        with replacing(path) as file:
            zip_folder(root, file)
    return path


def zip_folder(folder: Path, path: Path) -> None:
    """Every file of the folder, by name."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for member in sorted(folder.rglob("*")):
            if member.is_file():
                archive.write(member, member.relative_to(folder).as_posix())


def _write_sources(folder: Path, package: Package, face: str) -> list[str]:
    """The generated files and those of the runtime that belong to them; names of the C files."""
    folder.mkdir()
    wanted = (*package.runtime, "instance")
    for file in sorted(RUNTIME.iterdir()):
        if file.suffix in (".c", ".h") and (file.name.startswith(face) or file.stem in wanted):
            shutil.copy(file, folder)
    for name, text in package.sources.items():
        (folder / name).write_text(text)
    return sorted(file.name for file in folder.glob("*.c"))


def _describe(root: Path, package: Package, names: list[str], fmi: Version) -> None:
    interface, token = package.interface, token_of(package.sources)
    if fmi == 2:
        xml = fmi2_description.model_description(interface, token, names, package.derivatives)
        (root / "model.png").write_bytes(package.icons["icon.png"])
    else:
        xml = fmi3_description.model_description(interface, token, package.derivatives)
        files = "\n".join(f'      <SourceFile name="{name}"/>' for name in names)
        build = _BUILD_DESCRIPTION.format(identifier=interface.identifier, files=files)
        (root / "sources" / "buildDescription.xml").write_text(build)
        folder = root / "terminalsAndIcons"
        folder.mkdir()
        (folder / "terminalsAndIcons.xml").write_bytes(fmi3_description.terminals(interface))
        for name, content in package.icons.items():
            (folder / name).write_bytes(content)
    (root / "modelDescription.xml").write_bytes(xml)


def _document(folder: Path, package: Package) -> None:
    folder.mkdir()
    (folder / "index.html").write_text(package.page, encoding="utf-8")


def _record(root: Path, package: Package) -> None:
    """Inputs and outputs of a short run of this very FMU, in the files of the FMI cross-check.

    There is none where the parameters do not let it run: they can be changed when it is used.
    """
    interface = package.interface
    stop = _SAMPLES * interface.step
    try:
        run = constant_run(root, package.push, interface.step, stop)
    except SimulationError as error:
        warnings.warn(f"{interface.identifier}.fmu has no recorded run: {error}", stacklevel=2)
        return
    inputs = pd.DataFrame({"time": [0.0, stop]} | {name: np.full(2, v) for name, v in package.push.items()})
    stem = root / "documentation" / interface.identifier
    inputs.to_csv(f"{stem}_in.csv", index=False)
    run.to_csv(f"{stem}_ref.csv", index=False)
    options = {"StartTime": 0, "StopTime": stop, "StepSize": interface.step, "RelTol": 1e-6}
    Path(f"{stem}_ref.opt").write_text("".join(f"{name},{value}\n" for name, value in options.items()))
