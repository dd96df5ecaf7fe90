"""Place 3: where model and logs disagree: a map, the arm, traces, the residual and what it depends on."""

from functools import partial
from pathlib import Path
from typing import Any

from nicegui import events, ui

from pyident.workbench import commands, figures
from pyident.workbench.linked import share_brush, share_cursor, show_arm
from pyident.workbench.places.tab import Tab

_MARGIN = 0.5  # s shown before and behind a bump
_LATER = 0.1  # s after the traces, which are looked at first, the scatters under them follow


def show(page: Tab) -> None:
    """The map, then the chosen equation."""
    bench = page.bench
    compared = bench.result("compare")
    ui.button("Compare model and logs", on_click=lambda: page.act(bench.compare)).props(
        'data-testid="compare" no-caps'
    ).set_enabled("compare" not in bench.jobs)
    if compared is None:
        ui.label("No comparison of this model with these logs yet.").props('data-testid="no-comparison"')
        return
    comparison = compared.comparison
    ui.label(comparison.sentence).classes("text-base").props('data-testid="where-sentence"')
    if not comparison.traces:
        ui.label("Identify it in place 2; a model that can be simulated shows where and why.").props(
            'data-testid="not-simulated"'
        )
        return
    equation = _Equation(page, compared)
    with ui.row().classes("w-full no-wrap max-lg:flex-wrap items-start"):
        with ui.column().classes("grow min-w-0"):
            _map(page, comparison)
        with ui.column().classes("w-96 max-lg:w-full shrink-0"):
            arm = next((a for a in compared.arms if a.log == equation.trace.log), None)
            if arm:
                show_arm(arm, height=260)
    equation.show()


class _Equation:
    """One equation on one log: traces, bumps and states, which all show the same span of time."""

    def __init__(self, page: Tab, compared: Any):
        self.page, self.comparison = page, compared.comparison
        self.trace = chosen_trace(page, self.comparison)
        self.bumps = self.comparison.bumps(self.trace)

    def show(self) -> None:
        """Draw all of it."""
        span = self.page.view.span
        _choice(self.page, self.comparison, self.trace)
        with ui.row().classes("w-full no-wrap max-md:flex-wrap"):
            with ui.column().classes("grow min-w-0"):
                self.traces = ui.plotly(figures.equation(self.trace, span, self.bumps)).classes("w-full")
                self.traces.props('data-testid="traces" role="figure" aria-label="traces of the equation"')
                self.traces.on("plotly_relayout", self._zoomed)
            with ui.column().classes("w-64 shrink-0"):
                self._bumps()
        self.brushed = ui.label("").classes("text-sm min-h-5").props('data-testid="brushed"')
        self.states = ui.plotly(figures.states(self.trace, span)).classes("w-full")
        self.states.props(
            'data-testid="states" role="figure" aria-label="residual against the state of the joint"'
        )
        share_cursor(self.traces, self.trace.log)
        share_brush(self.states, self.traces, self.brushed)

    def look_at(self, span: tuple[float, float] | None) -> None:
        """Show another span of time; the rest of the page stays."""
        at = self.trace.log, self.trace.coordinate
        self.page.look(span=span, log=at[0], coordinate=at[1])
        self.page.tell(commands.explaining(self.page.bench.inputs, *at, span, self.trace.band))
        self.traces.update_figure(figures.equation(self.trace, span, self.bumps))
        self.whole.set_visibility(span is not None)
        ui.timer(_LATER, lambda: self.states.update_figure(figures.states(self.trace, span)), once=True)

    def _zoomed(self, event: events.GenericEventArguments) -> None:
        left, right = event.args.get("xaxis.range[0]"), event.args.get("xaxis.range[1]")
        if left is not None and right is not None:
            self.look_at((float(left), float(right)))
        elif event.args.get("xaxis.autorange"):
            self.look_at(None)

    def _bumps(self) -> None:
        ui.label("Where it leaves the ribbon").classes("font-bold")
        if not self.bumps:
            ui.label("Nowhere.").props('data-testid="no-bumps"')
        for i, bump in enumerate(self.bumps):
            share = f"{bump.over_floor:.2g} × · {100 * bump.share:.0f} %"
            words = f"{i + 1}: {bump.start:.2f} to {bump.stop:.2f} s · {share}"
            span = (max(bump.start - _MARGIN, self.trace.time[0]), bump.stop + _MARGIN)
            ui.button(words, on_click=partial(self.look_at, span)).props(
                f'data-testid="bump-{i + 1}" flat dense no-caps align=left'
            )
        self.whole = ui.button("whole log", on_click=lambda: self.look_at(None)).props(
            'data-testid="whole" flat no-caps'
        )
        self.whole.set_visibility(self.page.view.span is not None)
        if self.bumps:
            ui.button("Which law would explain this?", on_click=lambda: self.page.go(place="why")).props(
                'data-testid="to-why" no-caps'
            )


def chosen_trace(page: Tab, comparison: Any) -> Any:
    """The trace that the page looks at, else that of the worst equation on the log where it leaves most."""
    listed = [t for t in comparison.traces if not page.view.log or t.log == page.view.log]
    listed = listed or list(comparison.traces)
    worst = comparison.where.coordinate if comparison.where else listed[0].coordinate
    coordinate = page.view.coordinate or worst
    found = next((t for t in listed if t.coordinate == coordinate), listed[0])
    try:
        return comparison.trace(found.log, found.coordinate, page.view.band)
    except ValueError:  # a band from the URL in which there is nothing
        return found


def _map(page: Tab, comparison: Any) -> None:
    plot = ui.plotly(figures.band_map(comparison.bins)).classes("w-full")
    plot.props('data-testid="map" role="figure" aria-label="rms over floor by equation and band"')
    words = "rms over the floor, with the values that the model has; a click shows a cell alone"
    if comparison.structural:
        words += ". The sentence above is of what stays when all values are fitted anew."
    ui.label(words).classes("text-sm")

    def chosen(event: events.GenericEventArguments) -> None:
        point = event.args["points"][0]
        coordinate = str(point["y"])
        band = figures.band_of(comparison.bins, coordinate, str(point["x"]))
        page.go(coordinate=coordinate, span=None, band=band)
        log = chosen_trace(page, comparison).log
        page.tell(commands.explaining(page.bench.inputs, log, coordinate, None, band))

    plot.on("plotly_click", chosen)


def _choice(page: Tab, comparison: Any, chosen: Any) -> None:
    logs = {t.log: Path(t.log).name for t in comparison.traces}
    coordinates = {t.coordinate: t.coordinate for t in comparison.traces}
    with ui.row().classes("items-center"):
        for key, names, value in (
            ("coordinate", coordinates, chosen.coordinate),
            ("log", logs, chosen.log),
        ):
            ui.select(
                names,
                value=value,
                label="equation" if key == "coordinate" else "log",
                on_change=lambda e, k=key: page.go(**{k: e.value, "span": None, "band": None}),
            ).props(f'data-testid="{key}"').classes("w-40")
        if chosen.band is None:
            ui.label(f"residual shown below {chosen.cutoff:.3g} Hz").classes("text-sm")
            return
        words = f"residual shown from {chosen.band[0]:.3g} to {chosen.band[1]:.3g} Hz"
        ui.label(words).classes("text-sm").props('data-testid="band"')
        ui.button("all frequencies", on_click=lambda: page.go(band=None)).props(
            'data-testid="all-frequencies" flat dense no-caps'
        )
