"""Equations -> FMU file: generate, compile, zip."""

import shutil
import tempfile
import zipfile
from pathlib import Path
from typing import Literal

from flexfmu import fmi2_description, fmi3_description
from flexfmu.compilation import HOST, PLATFORMS, compile_for
from flexfmu.documentation import documentation
from flexfmu.source import RUNTIME, model_sources, token_of
from flexfmu.variables import identifier
from flexmodels.atomic import replacing
from flexmodels.compiler import BuildError
from flexmodels.plant import Equations

__all__ = ["BuildError", "export_fmu"]
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


def export_fmu(
    equations: Equations,
    path: str | Path,
    fmi: Literal[2, 3] = 2,
    platforms: Literal["host", "all"] = "host",
    derivatives: bool = True,
) -> Path:
    """Write an FMU for model exchange and co-simulation, with its C sources. Raises BuildError.

    fmi          version of the standard
    platforms    this machine's, or Linux, Windows and macOS in one file (needs the package ziglang)
    derivatives  whether the binary provides directional (and, in FMI 3, adjoint) derivatives
    """
    path = Path(path)
    generated = model_sources(equations, derivatives)
    face = f"fmi{fmi}"
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        sources = root / "sources"
        names = _write_sources(sources, generated, face)
        for platform in PLATFORMS if platforms == "all" else [HOST]:
            binary = root / "binaries" / platform.folder(fmi) / f"{identifier(equations)}{platform.suffix}"
            binary.parent.mkdir(parents=True)
            compile_for(platform, sources, names, binary, native=platforms == "host")
        _describe(root, equations, token_of(generated), names, fmi, derivatives)
        with replacing(path) as file:
            _zip(root, file)
    return path


def _write_sources(folder: Path, generated: dict[str, str], face: str) -> list[str]:
    """The generated files and those of the runtime that this face needs; names of the C files."""
    folder.mkdir()
    for file in sorted(RUNTIME.iterdir()):
        if file.suffix in (".c", ".h") and (file.name.startswith(face) or not file.name.startswith("fmi")):
            shutil.copy(file, folder)
    for name, text in generated.items():
        (folder / name).write_text(text)
    return sorted(file.name for file in folder.glob("*.c"))


def _describe(
    root: Path, equations: Equations, token: str, names: list[str], fmi: int, derivatives: bool
) -> None:
    if fmi == 2:
        xml = fmi2_description.model_description(equations, token, names, derivatives)
    else:
        xml = fmi3_description.model_description(equations, token, derivatives)
        files = "\n".join(f'      <SourceFile name="{name}"/>' for name in names)
        build = _BUILD_DESCRIPTION.format(identifier=identifier(equations), files=files)
        (root / "sources" / "buildDescription.xml").write_text(build)
        icons = root / "terminalsAndIcons"
        icons.mkdir()
        (icons / "terminalsAndIcons.xml").write_bytes(fmi3_description.terminals(equations))
    (root / "modelDescription.xml").write_bytes(xml)
    (root / "documentation").mkdir()
    (root / "documentation" / "index.html").write_text(documentation(equations), encoding="utf-8")


def _zip(folder: Path, path: Path) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for member in sorted(folder.rglob("*")):
            if member.is_file():
                archive.write(member, member.relative_to(folder).as_posix())
