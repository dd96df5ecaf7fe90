"""Place 4: the verdict of the diagnosis, the laws by what they would take away, and adding one."""

from typing import TYPE_CHECKING, Any

from nicegui import ui

if TYPE_CHECKING:
    from pyident.workbench.page import Page

_LISTED = 8  # laws of a ranking


def show(page: "Page") -> None:
    """The verdict always first: a ranking is never to be mistaken for it."""
    bench = page.bench
    diagnosis = bench.result("diagnose")
    ui.button("Diagnose", on_click=lambda: page.act(bench.diagnose)).props(
        'data-testid="diagnose" no-caps'
    ).set_enabled("diagnose" not in bench.jobs)
    if diagnosis is None:
        ui.label("No diagnosis of this model and these logs yet.").props('data-testid="no-diagnosis"')
        return
    ui.label(diagnosis.sentence).classes("text-base").props('data-testid="sentence"')
    for i, finding in enumerate(diagnosis.findings):
        _finding(page, i, finding)
    joint = page.view.coordinate.partition(".")[0]
    _ranking(page, diagnosis, joint)
    for sentence in diagnosis.depends_on:
        ui.label(sentence).classes("text-sm opacity-70")
    _waterfall(page)


def _finding(page: "Page", number: int, finding: Any) -> None:
    with ui.card().classes("w-full").props(f'data-testid="finding-{number + 1}"'):
        if len(finding.tie) > 1:
            ui.label("These logs cannot tell these apart:").classes("text-sm")
        for i, named in enumerate(finding.tie):
            values = ", ".join(f"{n} {v:.4g} {named.units[n]}" for n, v in named.values.items())
            with ui.row().classes("items-center"):
                ui.label(f"{named.effect} at {named.joint}").classes("font-bold")
                ui.label(values).classes("text-sm")
                _add_button(page, named, f"add-{number + 1}-{i + 1}")
        held = finding.heldout_gain_percent
        on_unseen = "" if held is None else f", {held:.0f} % of the error on data that were not fitted"
        ui.label(f"takes {finding.share_percent:.0f} % of what exceeds the floor{on_unseen}")
        if finding.experiment:
            ui.label(f"To separate: {finding.experiment}").classes("text-sm")


def _ranking(page: "Page", diagnosis: Any, joint: str) -> None:
    title = f"Laws at {joint}, each by itself" if joint else "Laws, each by itself"
    ui.label(title).classes("font-bold mt-2")
    ui.label("A ranking is no verdict: what stands here may only imitate what is missing.").classes("text-sm")
    listed = [n for n in diagnosis.ranking if not joint or n.joint == joint][:_LISTED]
    for i, named in enumerate(listed):
        with ui.row().classes("items-center w-full").props(f'data-testid="law-{i + 1}"'):
            ui.label(f"{named.effect} at {named.joint}").classes("w-72")
            share = min(max(named.gain_percent / 100, 0.0), 1.0)
            ui.linear_progress(share, show_value=False).classes("w-40").props(
                f'aria-label="share of {named.effect}"'
            )
            ui.label(f"{named.gain_percent:.0f} % of what exceeds the floor").classes("text-sm")
            _add_button(page, named, f"try-{i + 1}")


def _add_button(page: "Page", named: Any, name: str) -> None:
    joint = int(named.joint.removeprefix("joint"))
    button = ui.button("Add", on_click=lambda: page.act(lambda: page.bench.add(named.effect, joint)))
    button.props(f'data-testid="{name}" dense no-caps').set_enabled("add" not in page.bench.jobs)


def _waterfall(page: "Page") -> None:
    last = next((r for (what, _), r in reversed(page.bench.results.items()) if what == "add"), None)
    if last is None:
        return
    ui.label("The last law that was tried, on data that were not fitted").classes("font-bold mt-2")
    rows = [
        {
            "what": s.name,
            "before": f"{s.before:.4g}",
            "after": f"{s.after:.4g}",
            "floor": f"{s.floor:.4g}",
            "unit": s.unit,
        }
        for s in last.waterfall
    ]
    columns = [
        {"name": n, "label": n, "field": n, "align": "left"}
        for n in ("what", "before", "after", "floor", "unit")
    ]
    ui.table(rows=rows, columns=columns).props('data-testid="waterfall" dense flat')
    ui.label("accepted" if last.accepted else f"refused: {last.reason}").props('data-testid="outcome"')
