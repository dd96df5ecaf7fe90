"""The parts of an FMU -> the file: sources, binaries, descriptions, documentation, a recorded run."""

import shutil
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from flexfmu.code.compilation import HOST, PLATFORMS, compile_for
from flexfmu.code.source import LICENSES, RUNTIME, token_of
from flexfmu.files import fmi2_description, fmi3_description
from flexfmu.files.provenance import zip_folder
from flexfmu.interface import Interface
from flexfmu.simulate import constant_run
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
    papers     what is there for people; None leaves it out, with the recorded run
    """

    interface: Interface
    runtime: tuple[str, ...]
    sources: dict[str, str]
    derivatives: bool
    papers: "Papers | None"


@dataclass(frozen=True)
class Papers:
    """For people who open the file.

    page       documentation/index.html
    icons      name -> content, `icon.png` and `icon.svg`
    push       constant inputs of the recorded run
    model      the robot file, as it was read; None where there was none
    """

    page: str
    icons: dict[str, bytes]
    push: dict[str, float]
    model: bytes | None = None


def write_fmu(package: Package, path: str | Path, fmi: Version, platforms: Platforms) -> Path:
    """Compile, describe, record, zip. Raises BuildError."""
    path, identifier = Path(path), package.interface.identifier
    with scratch_folder() as root:
        names = _write_sources(root / "sources", package, fmi)
        for platform in PLATFORMS if platforms == "all" else [HOST]:
            binary = root / "binaries" / platform.folder(fmi) / f"{identifier}{platform.suffix}"
            binary.parent.mkdir(parents=True)
            compile_for(platform, root / "sources", names, binary, native=platforms == "host")
        _describe(root, package, names, fmi)
        if package.papers:
            _document(root, package, package.papers, fmi)
            _record(root, package, package.papers)
        else:
            shutil.rmtree(root / "sources")
        with replacing(path) as file:
            zip_folder(root, file)
    return path


def _write_sources(folder: Path, package: Package, fmi: Version) -> list[str]:
    """The generated files and those of the runtime that belong to them; names of the C files."""
    folder.mkdir()
    wanted = (*package.runtime, "instance", "states", "step", "symbols", f"face{fmi}")
    for file in sorted(RUNTIME.rglob("*.[ch]")):
        if file.name.startswith(f"fmi{fmi}") or file.stem in wanted:
            shutil.copy(file, folder)
    for name, text in package.sources.items():
        (folder / name).write_text(text)
    return sorted(file.name for file in folder.glob("*.c"))


def _describe(root: Path, package: Package, names: list[str], fmi: Version) -> None:
    interface, token = package.interface, token_of(package.sources)
    listed = names if package.papers else []
    if fmi == 2:
        xml = fmi2_description.model_description(interface, token, listed, package.derivatives)
    else:
        xml = fmi3_description.model_description(interface, token, package.derivatives)
        files = "\n".join(f'      <SourceFile name="{name}"/>' for name in names)
        build = _BUILD_DESCRIPTION.format(identifier=interface.identifier, files=files)
        (root / "sources" / "buildDescription.xml").write_text(build)
        folder = root / "terminalsAndIcons"
        folder.mkdir()
        (folder / "terminalsAndIcons.xml").write_bytes(fmi3_description.terminals(interface))
    (root / "modelDescription.xml").write_bytes(xml)


def _document(root: Path, package: Package, papers: Papers, fmi: Version) -> None:
    folder = root / "documentation"
    licenses = folder / "licenses"
    licenses.mkdir(parents=True)
    (folder / "index.html").write_text(papers.page, encoding="utf-8")
    for file in sorted(LICENSES.iterdir()):
        shutil.copy(file, licenses)
    if papers.model is not None:
        (folder / "robot.toml").write_bytes(papers.model)
    if fmi == 2:
        (root / "model.png").write_bytes(papers.icons["icon.png"])
        return
    for name, content in papers.icons.items():
        (root / "terminalsAndIcons" / name).write_bytes(content)


def _record(root: Path, package: Package, papers: Papers) -> None:
    """Inputs and outputs of a short run of this very FMU, in the files of the FMI cross-check.

    There is none where the parameters do not let it run: they can be changed when it is used.
    """
    interface = package.interface
    stop = _SAMPLES * interface.step
    try:
        run = constant_run(root, papers.push, interface.step, stop)
    except SimulationError as error:
        warnings.warn(f"{interface.identifier}.fmu has no recorded run: {error}", stacklevel=2)
        return
    inputs = pd.DataFrame({"time": [0.0, stop]} | {name: np.full(2, v) for name, v in papers.push.items()})
    stem = root / "documentation" / interface.identifier
    inputs.to_csv(f"{stem}_in.csv", index=False)
    run.to_csv(f"{stem}_ref.csv", index=False)
    options = {"StartTime": 0, "StopTime": stop, "StepSize": interface.step, "RelTol": 1e-6}
    Path(f"{stem}_ref.opt").write_text("".join(f"{name},{value}\n" for name, value in options.items()))
