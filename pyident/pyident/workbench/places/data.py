"""Place 1: the files, what the checks say of them, which are fitted and which are held out."""

from collections.abc import Sequence
from functools import partial

from nicegui import events, ui

from pyident.workbench.linked import name_upload
from pyident.workbench.places import columns
from pyident.workbench.places.tab import Tab
from pyident.workbench.project import LARGEST_UPLOAD, LOGS, MODELS, ProjectError
from pyident.workbench.work import REFUSED


def show(page: Tab) -> None:
    """Drop files, choose their roles, run the checks."""
    bench = page.bench
    upload = ui.upload(
        label="Drop logs (CSV, Parquet, MAT), a robot (TOML, URDF, MJCF) or a mapping (TOML)",
        multiple=True,
        auto_upload=True,
        max_file_size=LARGEST_UPLOAD,
        on_upload=lambda e: keep(page, e, (*LOGS, *MODELS)),
        on_rejected=lambda: ui.notify("that file is too large for a project", type="negative"),
    ).classes("w-full")
    upload.props('data-testid="upload" accept=".csv,.parquet,.mat,.toml,.urdf,.xml"')
    name_upload(upload, "choose files")
    for name in bench.project.strangers:
        ui.label(f"{name} leads out of this folder and is not read; copy the file here.").classes(
            "text-negative text-sm"
        ).props('data-testid="stranger"')
    if not bench.project.logs:
        ui.label("There is no log in this folder yet.").props('data-testid="no-logs"')
        return
    checked = bench.checked
    for i, log in enumerate(bench.project.logs):
        with ui.card().classes("w-full").props(f'data-testid="log-{i}"'):
            with ui.row().classes("items-center w-full"):
                ui.label(log).classes("font-bold")
                ui.space()
                ui.button("Look", on_click=partial(columns.look, page, log)).props(
                    f'data-testid="look-{i}" flat dense no-caps'
                )
                ui.button("Propose a mapping", on_click=partial(page.act, partial(bench.propose, log))).props(
                    f'data-testid="propose-{i}" flat dense no-caps'
                )
                ui.toggle(
                    ["fit", "hold out", "leave out"],
                    value=bench.project.roles.get(log, "fit"),
                    on_change=lambda e, name=log: page.act(lambda: bench.assign(name, e.value)),
                ).props(f'data-testid="role-{i}" no-caps dense')
            for sentence in checked.get(log, []):
                bad = sentence.startswith(REFUSED)
                ui.label(sentence).classes("text-negative" if bad else "text-sm")
    columns.show(page)
    if not bench.project.model:
        ui.label("Choose a model in place 2; the checks need to know which joints a log is of.").props(
            'data-testid="no-model"'
        )
    ui.button("Check the logs", on_click=lambda: page.act(bench.check)).props(
        'data-testid="check" no-caps'
    ).set_enabled(bool(bench.project.model) and "check" not in bench.jobs)
    if bench.sound:
        ui.label("The checks have passed for exactly these logs and this model.").classes(
            "text-positive"
        ).props('data-testid="sound"')


async def keep(page: Tab, event: events.UploadEventArguments, endings: Sequence[str]) -> None:
    """An uploaded file becomes a file of the folder; nothing that is there is replaced."""
    bench = page.bench
    try:
        name = event.file.name
        path = bench.project.path(name)
        if path.suffix not in endings:
            raise ProjectError(f"{name}: here, files end in {', '.join(endings)}")
        if path.exists():
            raise ProjectError(f"{name} is in the project already; rename the file or delete the old one")
        await event.file.save(path)
    except (ProjectError, OSError) as error:
        ui.notify(str(error), type="negative", multi_line=True)
        return
    starts = path.suffix in MODELS and tuple(endings) == MODELS
    bench.change(bench.project.starting_from(name) if starts else bench.project)
