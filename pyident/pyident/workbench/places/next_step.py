"""Place 5: the next measurement, and the model for other tools."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, Literal

from nicegui import ui

from flexmodels.coordinate import joint_number
from pyident.workbench.places.tab import Tab

_SHOWN = 8  # laws that these logs cannot show
_FORMATS: tuple[tuple[str, str, str, Literal[2, 3]], ...] = (
    ("URDF", "urdf", ".urdf", 2),
    ("MJCF", "mjcf", ".xml", 2),
    ("FMU (FMI 2)", "fmi2", ".fmu", 2),
    ("FMU (FMI 3)", "fmi3", ".fmu", 3),
    ("SSP", "ssp", ".ssp", 2),
)
_REPORTS: tuple[tuple[Literal["compare", "diagnose"], str], ...] = (
    ("compare", "Report: where it fails"),
    ("diagnose", "Report: the diagnosis"),
)


def show(page: Tab) -> None:
    """What would separate or reveal, and downloads."""
    bench = page.bench
    diagnosis = bench.result("diagnose")
    ui.label("The next experiment").classes("text-lg")
    asked = list(_questions(diagnosis)) if diagnosis else []
    for i, (sentence, separate, reveal) in enumerate(asked, start=1):
        with ui.row().classes("items-center no-wrap"):
            ui.label(sentence)
            ui.button(
                "Plan the motion", on_click=partial(page.act, partial(bench.plan, separate, reveal))
            ).props(f'data-testid="plan-{i}" flat dense no-caps').set_enabled("plan" not in bench.jobs)
    if not asked:
        words = (
            "The diagnosis asks for no further motion."
            if diagnosis
            else "Run the diagnosis in place 4 first."
        )
        ui.label(words).props('data-testid="no-experiment"')
    plan = bench.result("plan")
    if plan:
        name, promise = plan
        with ui.row().classes("items-center"):
            ui.label(f"{name}: {promise}").props('data-testid="promise"')
            ui.button("Download", on_click=partial(ui.download.file, bench.project.path(name))).props(
                'data-testid="download-plan" no-caps'
            )
    ui.label("Take the model with you").classes("text-lg mt-4")
    with ui.row():
        ui.button(
            "Robot file (TOML)", on_click=lambda: ui.download.file(bench.project.path(bench.project.model))
        ).props('data-testid="download-model" no-caps').set_enabled(
            (bench.project.folder / bench.project.model).is_file()
        )
        for label, kind, ending, fmi in _FORMATS:
            ui.button(label, on_click=partial(page.act, partial(bench.export, ending, fmi))).props(
                f'data-testid="export-{kind}" no-caps'
            ).set_enabled("export" not in bench.jobs and bool(bench.project.model))
        ui.button("Bundle of all formats (zip)", on_click=partial(page.act, bench.bundle)).props(
            'data-testid="bundle" no-caps'
        ).set_enabled("bundle" not in bench.jobs)
        ui.button(
            "Script of everything that was done",
            on_click=lambda: ui.download.content(bench.project.script(), "replay.sh"),
        ).props('data-testid="download-script" no-caps')
    _reports(page)
    for what in ("export", "report", "bundle"):
        made = bench.result(what)
        if made:
            with ui.row().classes("items-center"):
                ui.label(f"wrote {Path(made).name}").props(f'data-testid="made-{what}"')
                ui.button("Download", on_click=partial(ui.download.file, made)).props(
                    f'data-testid="download-{what}" no-caps'
                )
    ui.label("What was done, as commands").classes("text-lg mt-4")
    ui.label(bench.project.script()).classes("font-mono text-xs whitespace-pre-wrap").props(
        'data-testid="script"'
    )


def _questions(diagnosis: Any) -> Iterator[tuple[str, tuple[str, ...], str]]:
    """What further motions would answer: in words, the two laws to tell apart, or the one to show."""
    for finding in diagnosis.findings:
        pair = [law for law in finding.tie[:2] if not law.describes]
        if len(pair) > 1:
            names = " or ".join(f"{law.effect} at {law.joint}" for law in pair)
            yield f"{names}? {finding.experiment}", tuple(law.suspect for law in pair), ""
    for limit in [x for x in diagnosis.limits if x.reason][:_SHOWN]:
        asked = f"{limit.effect}@{joint_number(limit.joint)}"
        yield f"{limit.effect} at {limit.joint} cannot be seen: {limit.reason}", (), asked


def _reports(page: Tab) -> None:
    """Pages of what was found, which need nothing else to be read."""
    with ui.row():
        for what, label in _REPORTS:
            ui.button(label, on_click=partial(page.act, partial(page.bench.report, what))).props(
                f'data-testid="report-{what}" no-caps'
            ).set_enabled(page.bench.result(what) is not None and "report" not in page.bench.jobs)
