"""Equations -> FMU file: the arm with its controller, the plant alone or the controller alone."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from flexfmu.code.compilation import ALL_LANES, host_lanes
from flexfmu.code.source import controller_sources, model_sources
from flexfmu.files.documentation import controller_page, plant_page
from flexfmu.files.icon import ICONS, icons
from flexfmu.inertia import require_inertia
from flexfmu.interface import controller_interface, plant_interface
from flexfmu.package import Package, Papers, Platforms, Version, write_fmu
from flexfmu.variables import states
from flexmodels.compiling.compiler import BuildError
from flexmodels.coordinate import of_joint
from flexmodels.mechanics.plant import Equations

_PLANT = ("plant", "integration", "equilibrium", "scalar", "target", "fused")
_BATCH = ("batch", "lanes", "lanes_loop")
__all__ = ["BuildError", "export_controller", "export_fmu"]


def export_fmu(
    equations: Equations,
    path: str | Path,
    fmi: Version = 2,
    platforms: Platforms = "host",
    light: bool = False,
    model: bytes | None = None,
) -> Path:
    """Write an FMU for model exchange and co-simulation. Raises BuildError.

    equations    with its controller inside, or with controller None: its inputs are then the torques
    fmi          version of the standard
    platforms    this machine's, or Linux, Windows and macOS in one file (needs the package ziglang)
    light        to be simulated and thrown away: no directional (and, in FMI 3, adjoint) derivatives,
                 sources, pictures, documentation and recorded run; nor is it asked whether it could start
    model        content of the robot file, kept in the documentation with its hash
    """
    interface = plant_interface(equations)
    lanes = () if equations.drives else host_lanes() if light else ALL_LANES
    batch = () if equations.drives else (*_BATCH, *(f"lanes_{name}" for name in lanes))
    smooth = equations.servo is None and not equations.drives  # dead bands, limits, held laws are not
    derivatives = not light and smooth
    adjoint = derivatives and fmi == 3  # FMI 2.0 has none
    inside = [*_loop(equations), *["sensitivities"] * derivatives, *["adjoint"] * adjoint]
    papers = None
    if not light:
        require_inertia(equations)
        page = plant_page(equations, interface, model)
        papers = Papers(page, icons(equations, ICONS[fmi]), _push(equations), model)
    package = Package(
        interface=interface,
        runtime=(*_PLANT, *batch, *inside),
        sources=model_sources(equations, derivatives, adjoint, lanes),
        derivatives=derivatives,
        papers=papers,
    )
    return write_fmu(package, path, fmi, platforms)


def export_controller(
    equations: Equations, integral: Mapping[str, float], path: str | Path, platforms: Platforms = "host"
) -> Path:
    """Write the digital controller alone as an FMU 2.0 for co-simulation. Raises BuildError.

    integral     start of every `joint{k}.I_0`: the torque that holds the plant at its own start [N m or N]
    """
    interface = controller_interface(equations, integral)
    push = {f"joint{k}.r": 0.01 for k in range(1, equations.joints + 1)}
    package = Package(
        interface=interface,
        runtime=("controller", "pid"),
        sources=controller_sources(interface),
        derivatives=False,
        papers=Papers(controller_page(equations, interface), icons(equations, ICONS[2]), push),
    )
    return write_fmu(package, path, 2, platforms)


def _loop(equations: Equations) -> tuple[str, ...]:
    """The runtime's file that closes the loop."""
    if equations.drives:
        return ("drive",)
    return ("servo",) if equations.servo else ("pid",) if equations.controller else ()


def without_controller(equations: Equations) -> Equations:
    """The plant alone, whose inputs are the motor torques."""
    return replace(equations, name=f"{equations.name}_plant", controller=None, servo=None)


def with_drives(equations: Equations) -> Equations:
    """The plant alone with drives that take a controller's law (runtime/loop/drive.h)."""
    return replace(without_controller(equations), drives=True)


def _push(equations: Equations) -> dict[str, float]:
    """Constant inputs that move every joint: 1.5 times its dry friction at rest and a little more."""
    x, u = [0.0] * len(states(equations)), [0.0] * equations.joints
    p, stuck = list(equations.parameters.values()), [0.0] * equations.joints
    upper, _ = equations.breakaway(x, u, p, stuck)
    signal = "tau_ff" if equations.controller or equations.servo else "tau"
    levels = upper.full().ravel()
    return {of_joint(k, signal): 1.0 + 1.5 * float(f) for k, f in enumerate(levels, start=1)}
