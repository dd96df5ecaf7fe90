"""Place 5: the next measurement, and the model for other tools."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import ui

from pyident.workbench import work
from pyident.workbench.project import command

if TYPE_CHECKING:
    from pyident.workbench.page import Page


_SHOWN = 8  # laws that these logs cannot show


def show(page: "Page") -> None:
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
            ui.button("Download", on_click=lambda: ui.download.file(bench.project.path(name))).props(
                'data-testid="download-plan" no-caps'
            )
    ui.label("Take the model with you").classes("text-lg mt-4")
    with ui.row():
        ui.button(
            "Robot file (TOML)", on_click=lambda: ui.download.file(bench.project.path(bench.project.model))
        ).props('data-testid="download-model" no-caps').set_enabled(
            (bench.project.folder / bench.project.model).is_file()
        )
        for fmi in (2, 3):
            ui.button(f"FMU (FMI {fmi})", on_click=partial(page.act, partial(_export, page, fmi))).props(
                f'data-testid="export-fmi{fmi}" no-caps'
            )
        ui.button("Bundle of all formats (zip)", on_click=partial(page.act, bench.bundle)).props(
            'data-testid="bundle" no-caps'
        ).set_enabled("bundle" not in bench.jobs)
        ui.button(
            "Script of everything that was done",
            on_click=lambda: ui.download.content(bench.project.script(), "replay.sh"),
        ).props('data-testid="download-script" no-caps')
    for what in ("export", "bundle"):
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
        if len(finding.tie) > 1:
            pair = [_at(named) for named in finding.tie[:2]]
            yield f"{' or '.join(pair)}? {finding.experiment}", tuple(pair), ""
    for limit in [x for x in diagnosis.limits if x.reason][:_SHOWN]:
        yield f"{_at(limit)} cannot be seen: {limit.reason}", (), _at(limit)


def _at(law: Any) -> str:
    """A law as `excite` names it."""
    return f"{law.effect}@{law.joint.removeprefix('joint')}"


def _export(page: "Page", fmi: int) -> None:
    bench = page.bench
    output = bench.project.folder / bench.project.free_name(Path(bench.project.model).stem, ".fmu")
    line = command("export", Path(bench.inputs.model).name, "-o", output.name, "--fmi", str(fmi))
    bench.change(bench.project.after(line))
    bench.start("export", f"exporting {output.name}", work.exported, bench.inputs.model, str(output), fmi)
