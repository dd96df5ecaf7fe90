"""In place 1, one file: its channels to look at, and the mapping that it seems to want."""

from typing import Any

from nicegui import events, run, ui

from pyident.workbench import commands
from pyident.workbench.channels import Channels
from pyident.workbench.places.tab import Tab


def show(page: Tab) -> None:
    """The channels of the file that was chosen, and the proposal for it."""
    if page.channels is not None:
        _plot(page.channels)
    proposal = page.bench.result("propose")
    if proposal is not None:
        _proposal(page, *proposal)


async def look(page: Tab, log: str) -> None:
    """Read a file's channels, unless they are in memory already."""
    path = str(page.bench.project.path(log))
    try:
        if page.channels is None or not page.channels.is_of(path):
            page.channels = await run.io_bound(Channels, path)
    except (ValueError, OSError) as error:
        ui.notify(str(error), type="negative", multi_line=True)
    page.tell(commands.inspecting(page.bench.inputs, log))
    page.go()


def _plot(channels: Channels) -> None:
    plot = ui.plotly(channels.figure()).classes("w-full")
    plot.props('data-testid="channels" role="figure" aria-label="channels of the file"')

    def zoomed(event: events.GenericEventArguments) -> None:
        left, right = event.args.get("xaxis.range[0]"), event.args.get("xaxis.range[1]")
        if left is not None and right is not None:
            plot.update_figure(channels.figure((float(left), float(right))))
        elif event.args.get("xaxis.autorange"):
            plot.update_figure(channels.figure())

    plot.on("plotly_relayout", zoomed)


def _proposal(page: Tab, log: str, rows: list[dict[str, Any]], questions: list[str], text: str) -> None:
    ui.label(f"What {log} seems to hold").classes("font-bold")
    columns = [
        {"name": n, "label": n, "field": n, "align": "left"} for n in ("column", "signal", "unit", "sure")
    ]
    ui.table(rows=rows, columns=columns).props('data-testid="proposal" dense flat')
    for question in questions:
        ui.label(f"? {question}").classes("text-negative text-sm")
    written = (
        ui.textarea("mapping, to correct", value=text)
        .classes("w-full font-mono")
        .props('data-testid="mapping" autogrow')
    )
    ui.button(
        "Use this mapping", on_click=lambda: page.act(lambda: page.bench.use_mapping(written.value or ""))
    ).props('data-testid="use-mapping" no-caps')
