"""Place 2: the robot as a tree, its joints and their laws, what the logs can tell of its parameters."""

from typing import TYPE_CHECKING

import numpy as np
from nicegui import ui

from pyident.kinematics.skeleton import segments, skeleton
from pyident.workbench.scene import Arm3D

if TYPE_CHECKING:
    from pyident.workbench.page import Page

_BLUE = "#2b6ca3"


def show(page: "Page") -> None:
    """Choose a model; see it; fit it."""
    import pyident as pi
    from flexmodels.files.robot_file import shipped

    bench = page.bench
    names = [*bench.project.models, *shipped()]
    ui.select(
        names,
        value=bench.project.model if bench.project.model in names else None,
        label="model",
        on_change=lambda e: page.act(lambda: bench.change(bench.project.starting_from(e.value))),
    ).classes("w-72").props('data-testid="model" aria-label="model"')
    if not bench.project.model:
        ui.label("Drop a robot file in place 1, or take one that ships.").props('data-testid="choose-model"')
        return
    try:
        robot = pi.load_robot(bench.inputs.model)
    except ValueError as error:
        ui.label(str(error)).classes("text-negative").props('data-testid="model-error" role="alert"')
        return
    ui.label(robot.description)
    with ui.row().classes("w-full"):
        points = skeleton(robot)
        reach = max(float(np.abs(points).max()), 0.1)
        Arm3D(segments(robot), reach, [_BLUE] * len(robot.joints)).play([points])
        with ui.column().classes("grow"):
            for k, joint in robot.numbered:
                _joint(k, joint)
    _rank(page)


def _joint(k: int, joint) -> None:
    bends = "twists and bends" if joint.flexible and joint.bends else "twists" if joint.flexible else "rigid"
    with ui.row().classes("items-center gap-1").props(f'data-testid="joint-{k}"'):
        ui.label(f"{k} {joint.name} · {joint.kind}, {bends}").classes("font-bold")
        for law in joint.values:
            ui.badge(law, color="blue-grey")


def _rank(page: "Page") -> None:
    bench = page.bench
    fit = bench.result("identify")
    if fit is not None:
        ui.label(fit.summary()).classes("whitespace-pre font-mono text-xs").props('data-testid="fit"')
    ui.button("Identify from the fitted logs", on_click=lambda: page.act(bench.identify)).props(
        'data-testid="identify" no-caps'
    ).set_enabled(bench.sound)
