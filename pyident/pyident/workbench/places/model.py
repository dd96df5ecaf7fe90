"""Place 2: the robot as a tree, its joints and their laws, what the logs can tell of its parameters."""

from pathlib import Path
from typing import Any

from nicegui import ui

from pyident.verbs.figures.pictures import standing_arm
from pyident.workbench.linked import name_upload, show_arm
from pyident.workbench.places.data import keep
from pyident.workbench.places.tab import Tab
from pyident.workbench.project import LARGEST_UPLOAD, MODELS, ProjectError


def show(page: Tab) -> None:
    """Choose a model; see it; fit it."""
    import pyident as pi
    from flexmodels.files.robot_file import shipped

    bench = page.bench
    names = [*bench.project.models, *shipped()]
    ui.select(
        names,
        value=bench.project.model if bench.project.model in names else None,
        label="model",
        on_change=lambda e: page.act(lambda: bench.choose(e.value)),
    ).classes("w-72").props('data-testid="model" aria-label="model"')
    upload = ui.upload(
        label="Drop a robot: TOML, URDF or MJCF",
        auto_upload=True,
        max_file_size=LARGEST_UPLOAD,
        on_upload=lambda e: keep(page, e, MODELS),
    )
    upload.props('data-testid="upload-model" flat bordered accept=".toml,.urdf,.xml"')
    name_upload(upload, "choose a robot file")
    if Path(bench.project.model).suffix in (".urdf", ".xml"):
        _import(page)
        return
    if not bench.project.model:
        ui.label("Drop a robot file, or take one that ships.").props('data-testid="choose-model"')
        return
    try:
        robot = pi.load_robot(bench.inputs.model)
    except ValueError as error:
        ui.label(str(error)).classes("text-negative").props('data-testid="model-error" role="alert"')
        return
    ui.label(robot.description)
    with ui.row().classes("w-full no-wrap max-lg:flex-wrap"):
        with ui.column().classes("w-[32rem] max-md:w-full shrink-0"):
            show_arm(standing_arm(robot))
        with ui.column().classes("grow"):
            for k, joint in robot.numbered:
                _joint(k, joint)
                for part in _driven(robot, k):
                    ui.badge(part, color="teal-9").props(f'data-testid="drive-{k}"')
    _rank(page)


def _import(page: Tab) -> None:
    """Which joints of somebody else's robot are flexible: its file does not say."""
    name = page.bench.project.model
    ui.label(f"{name} becomes a robot file. Which of its joints, counted from 1, are flexible?")
    with ui.row().classes("items-end"):
        bend = ui.input("twist and bend, such as 1,2").props('data-testid="flexible"')
        twist = ui.input("only twist").props('data-testid="twist"')
        ui.button(
            "Import",
            on_click=lambda: page.act(
                lambda: page.bench.bring(name, _numbers(bend.value or ""), _numbers(twist.value or ""))
            ),
        ).props('data-testid="import" no-caps')


def _numbers(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(word) for word in text.split(",") if word.strip())
    except ValueError:
        raise ProjectError(f"joints are numbers such as 1,2, not {text!r}") from None


def _joint(k: int, joint) -> None:
    bends = "twists and bends" if joint.flexible and joint.bends else "twists" if joint.flexible else "rigid"
    with ui.row().classes("items-center gap-1").props(f'data-testid="joint-{k}"'):
        ui.label(f"{k} {joint.name} · {joint.kind}, {bends}").classes("font-bold")
        for law in joint.values:
            ui.badge(law, color="blue-grey-8")


def _driven(robot: Any, k: int) -> list[str]:
    """What stands between a joint and its motor, and what commands this."""
    parts, gear = [], robot.transmission
    if gear:
        turns = " ".join(f"{r:.4g}" for r in gear.ratio[k - 1] if r)
        parts.append(f"transmission {turns}" + (f", {gear.drive[k - 1]:.4g} N m/A" if gear.drive else ""))
    if robot.servo:
        parts.append(f"servo, kp {robot.servo.kp[k - 1]:.4g}, kt {robot.servo.kt[k - 1]:.4g}")
    if robot.controller:
        parts.append(f"PID at {robot.controller.rate:.4g} Hz, torque held")
    return parts


def _rank(page: Tab) -> None:
    bench = page.bench
    fit = bench.result("identify")
    if fit is not None:
        ui.label(fit.determined).props('data-testid="rank"')
        ui.label(fit.summary).classes("whitespace-pre font-mono text-xs").props('data-testid="fit"')
    ui.button("Identify from the fitted logs", on_click=lambda: page.act(bench.identify)).props(
        'data-testid="identify" no-caps'
    ).set_enabled(bench.sound)
