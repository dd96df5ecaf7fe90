"""Equations -> FMU file: the arm with its controller, the plant alone or the controller alone."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from flexfmu.documentation import controller_page, plant_page
from flexfmu.icon import icons
from flexfmu.interface import controller_interface, plant_interface
from flexfmu.package import Package, Platforms, Version, write_fmu
from flexfmu.source import controller_sources, model_sources
from flexfmu.variables import states
from flexmodels.compiler import BuildError
from flexmodels.coordinate import of_joint, reference_of
from flexmodels.mechanics.plant import Equations

__all__ = ["BuildError", "export_controller", "export_fmu"]


def export_fmu(
    equations: Equations,
    path: str | Path,
    fmi: Version = 2,
    platforms: Platforms = "host",
    derivatives: bool = True,
) -> Path:
    """Write an FMU for model exchange and co-simulation, with its C sources. Raises BuildError.

    equations    with its controller inside, or with controller None: its inputs are then the torques
    fmi          version of the standard
    platforms    this machine's, or Linux, Windows and macOS in one file (needs the package ziglang)
    derivatives  whether the binary provides directional (and, in FMI 3, adjoint) derivatives
    """
    interface = plant_interface(equations)
    derivatives = derivatives and equations.servo is None  # a servo's dead band and limits have none
    package = Package(
        interface=interface,
        runtime=("plant", "equilibrium", *_loop(equations)),
        sources=model_sources(equations, derivatives),
        derivatives=derivatives,
        page=plant_page(equations, interface),
        icons=icons(equations),
        push=_push(equations),
    )
    return write_fmu(package, path, fmi, platforms)


def export_controller(
    equations: Equations, integral: Mapping[str, float], path: str | Path, platforms: Platforms = "host"
) -> Path:
    """Write the digital controller alone as an FMU 2.0 for co-simulation. Raises BuildError.

    integral     start of every `joint{k}.I_0`: the torque that holds the plant at its start [N m or N]
    """
    interface = controller_interface(equations, integral)
    package = Package(
        interface=interface,
        runtime=("controller", "pid"),
        sources=controller_sources(interface),
        derivatives=False,
        page=controller_page(equations, interface),
        icons=icons(equations),
        push={reference_of(k): 0.01 for k in range(1, equations.joints + 1)},
    )
    return write_fmu(package, path, 2, platforms)


def _loop(equations: Equations) -> tuple[str, ...]:
    """The runtime's file that closes the loop."""
    return ("servo",) if equations.servo else ("pid",) if equations.controller else ()


def without_controller(equations: Equations) -> Equations:
    """The plant alone, whose inputs are the motor torques."""
    return replace(equations, name=f"{equations.name}_plant", controller=None, servo=None)


def _push(equations: Equations) -> dict[str, float]:
    """Constant inputs that move every joint: 1.5 times its dry friction at rest and a little more."""
    x, u = [0.0] * len(states(equations)), [0.0] * equations.joints
    upper, _ = equations.breakaway(x, u, list(equations.parameters.values()))
    signal = "tau_ff" if equations.controller or equations.servo else "tau"
    levels = upper.full().ravel()
    return {of_joint(k, signal): 1.0 + 1.5 * float(f) for k, f in enumerate(levels, start=1)}
