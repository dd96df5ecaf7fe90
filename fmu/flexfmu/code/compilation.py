"""C sources -> shared libraries, for this machine or for every platform."""

import platform
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from flexfmu.code.kept_objects import KeptObjects
from flexmodels.compiling.compiler import BuildError, compiler, zig
from flexmodels.scratch import scratch_folder


@dataclass(frozen=True)
class Platform:
    """A target: processor and system in FMI 3.0's names, suffix of libraries, target of `zig cc`."""

    processor: str
    system: str
    suffix: str
    zig: str

    def folder(self, fmi: int) -> str:
        """Its folder below binaries/."""
        if fmi == 2 and self.processor == "x86_64":
            return {"linux": "linux64", "windows": "win64", "darwin": "darwin64"}[self.system]
        return f"{self.processor}-{self.system}"


# Old C libraries, so that old machines load the binaries too.
PLATFORMS = (
    Platform("x86_64", "linux", ".so", "x86_64-linux-gnu.2.17"),
    Platform("aarch64", "linux", ".so", "aarch64-linux-gnu.2.17"),
    Platform("x86_64", "windows", ".dll", "x86_64-windows-gnu"),
    Platform("x86_64", "darwin", ".dylib", "x86_64-macos"),
    Platform("aarch64", "darwin", ".dylib", "aarch64-macos"),
)


def _host() -> Platform:
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, "linux")
    machine = platform.machine().lower()
    processor = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    suffix = {"windows": ".dll", "darwin": ".dylib"}.get(system, ".so")
    return Platform(processor, system, suffix, "native")


HOST = _host()
ALL_LANES = ("avx2", "avx512")  # vectors of runs


def host_lanes() -> tuple[str, ...]:
    """The vector of runs that fits this machine best; the FMU looks itself what is there where it runs."""
    described = Path("/proc/cpuinfo")
    flags = described.read_text().split() if described.exists() else []
    if HOST.processor != "x86_64":
        return ()
    return ("avx512",) if {"avx512f", "avx512dq"} <= set(flags) else ("avx2",)


_FLAGS = ["-std=gnu99", "-fvisibility=hidden", "-ffp-contract=off", "-DFMI3_OVERRIDE_FUNCTION_PREFIX"]
# Long and almost without branches: the same bits and as fast after -Og, and compiled in a third of the time.
_STRAIGHT = ("model.c", "model_forward.c", "model_adjoint.c")
# Chosen where the processor has them, with fused operations; the vectors are some 8 % slower after -Og.
_CHOSEN = ("fused.c", *(f"lanes_{name}.c" for name in ALL_LANES))


def compile_for(target: Platform, folder: Path, sources: list[str], binary: Path, native: bool) -> None:
    """Compile the C files of `folder` into `binary`; `native` takes this machine's own compiler."""
    command = [*compiler()] if native else [*zig(), "-target", target.zig]
    flags = _FLAGS if target.system == "windows" else [*_FLAGS, "-fPIC"]
    kept = KeptObjects(command)
    with scratch_folder() as built:
        objects = []
        for name in sorted(sources):
            words = [*command, *flags, *_optimisation(name), "-c", name, "-o"]
            objects.append(built / f"{name}.o")
            compiled = partial(_run, [*words, str(objects[-1])], folder)
            kept.place(words, folder / name, objects[-1], compiled)
        _run([*command, "-shared", *map(str, objects), "-o", str(binary), "-lm"], folder)
    for leftover in binary.parent.iterdir():  # debug and import files of the Windows linker
        if leftover != binary:
            leftover.unlink()


def _optimisation(name: str) -> tuple[str, ...]:
    if name in _CHOSEN:
        return "-O1", "-fexpensive-optimizations", "-ffp-contract=fast"  # GCC fuses with both
    return ("-Og",) if name in _STRAIGHT else ("-O2",)


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"the C compiler failed ({' '.join(command[:3])} ...):\n{done.stderr.strip()}")
