"""Place 3: where model and logs disagree: a map, traces, the residual in its ribbon, its dependences."""

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import events, ui

from pyident.workbench.thinned import thinned, thinned_band, window

if TYPE_CHECKING:
    from pyident.workbench.page import Page

_SCALE = [[0, "#fffaf0"], [0.2, "#fdd9a0"], [0.5, "#f3a14b"], [0.75, "#cf6214"], [1, "#521d02"]]
_SCATTER = 1_500  # points of a residual against a state


def show(page: "Page") -> None:
    """The map, then the chosen equation."""
    bench = page.bench
    comparison = bench.result("compare")
    ui.button("Compare model and logs", on_click=lambda: page.act(bench.compare)).props(
        'data-testid="compare" no-caps'
    ).set_enabled("compare" not in bench.jobs)
    if comparison is None:
        ui.label("No comparison of this model with these logs yet.").props('data-testid="no-comparison"')
        return
    ui.label(comparison.sentence).classes("text-base").props('data-testid="where-sentence"')
    _map(page, comparison)
    _Equation(page, comparison).show()


class _Equation:
    """One equation on one log: traces, bumps and states, which all show the same span of time."""

    def __init__(self, page: "Page", comparison: Any):
        self.page, self.comparison = page, comparison
        listed = [t for t in comparison.traces if not page.view.log or t.log == page.view.log]
        listed = listed or list(comparison.traces)
        worst = comparison.where.coordinate if comparison.where else listed[0].coordinate
        coordinate = page.view.coordinate or worst
        self.trace = next((t for t in listed if t.coordinate == coordinate), listed[0])

    def show(self) -> None:
        """Draw all of it."""
        _choice(self.page, self.comparison, self.trace)
        with ui.row().classes("w-full no-wrap max-md:flex-wrap"):
            with ui.column().classes("grow min-w-0"):
                self.traces = ui.plotly(_traces(self.trace, self.page.view.span)).classes("w-full")
                self.traces.props('data-testid="traces" aria-label="traces of the equation"')
                self.traces.on("plotly_relayout", self._zoomed)
            with ui.column().classes("w-64 shrink-0"):
                self._bumps()
        self.states = ui.plotly(_states(self.trace, self.page.view.span)).classes("w-full")
        self.states.props('data-testid="states" aria-label="residual against the state of the joint"')

    def look_at(self, span: tuple[float, float] | None) -> None:
        """Show another span of time; the rest of the page stays."""
        self.page.look(span=span)
        self.traces.update_figure(_traces(self.trace, span))
        self.states.update_figure(_states(self.trace, span))
        self.whole.set_visibility(span is not None)

    def _zoomed(self, event: events.GenericEventArguments) -> None:
        left, right = event.args.get("xaxis.range[0]"), event.args.get("xaxis.range[1]")
        if left is not None and right is not None:
            self.look_at((float(left), float(right)))

    def _bumps(self) -> None:
        ui.label("Where it leaves the ribbon").classes("font-bold")
        listed = self.comparison.bumps(self.trace)
        if not listed:
            ui.label("Nowhere.").props('data-testid="no-bumps"')
        for i, bump in enumerate(listed):
            share = f"{bump.over_floor:.2g} × · {100 * bump.share:.0f} %"
            words = f"{i + 1}: {bump.start:.2f} to {bump.stop:.2f} s · {share}"
            span = (bump.start - 0.5, bump.stop + 0.5)
            ui.button(words, on_click=partial(self.look_at, span)).props(
                f'data-testid="bump-{i + 1}" flat dense no-caps align=left'
            )
        self.whole = ui.button("whole log", on_click=lambda: self.look_at(None)).props(
            'data-testid="whole" flat no-caps'
        )
        self.whole.set_visibility(self.page.view.span is not None)
        if listed:
            ui.button("Which law would explain this?", on_click=lambda: self.page.go(place="why")).props(
                'data-testid="to-why" no-caps'
            )


def _map(page: "Page", comparison: Any) -> None:
    bins = [b for b in comparison.bins if b.kind == "frequency"]
    rows = list(dict.fromkeys(b.coordinate for b in bins))
    bands = list(dict.fromkeys((b.low, b.label) for b in sorted(bins, key=lambda b: b.low)))
    labels = [label for _, label in bands]
    ratio = np.full((len(rows), len(labels)), np.nan)
    for b in bins:
        ratio[rows.index(b.coordinate), labels.index(b.label)] = b.ratio
    shade = np.log10(np.maximum(ratio, 1.0))
    figure = {
        "data": [
            {
                "type": "heatmap",
                "x": labels,
                "y": rows,
                "z": _plain(shade),
                "text": [["" if np.isnan(v) else f"{v:.2g}" for v in row] for row in ratio],
                "texttemplate": "%{text}",
                "colorscale": _SCALE,
                "zmin": 0,
                "zmax": max(1.0, float(np.nanmax(shade))),
                "showscale": False,
                "hovertemplate": "%{y}, %{x}: %{text} times the floor<extra></extra>",
            }
        ],
        "layout": {
            "height": 90 + 24 * len(rows),
            "margin": {"l": 90, "r": 10, "t": 40, "b": 20},
            "xaxis": {"side": "top", "fixedrange": True},
            "yaxis": {"autorange": "reversed", "fixedrange": True},
        },
        "config": {"displayModeBar": False, "responsive": True},
    }
    plot = (
        ui.plotly(figure)
        .classes("w-full")
        .props('data-testid="map" aria-label="rms over floor by equation and band"')
    )

    def chosen(event: events.GenericEventArguments) -> None:
        point = event.args["points"][0]
        page.go(coordinate=str(point["y"]), span=None)

    plot.on("plotly_click", chosen)


def _choice(page: "Page", comparison: Any, chosen: Any) -> None:
    logs = list(dict.fromkeys(t.log for t in comparison.traces))
    coordinates = list(dict.fromkeys(t.coordinate for t in comparison.traces))
    with ui.row().classes("items-center"):
        for key, names, value in (
            ("coordinate", coordinates, chosen.coordinate),
            ("log", logs, chosen.log),
        ):
            ui.select(
                names,
                value=value,
                label="equation" if key == "coordinate" else "log",
                on_change=lambda e, k=key: page.go(**{k: e.value, "span": None}),
            ).props(f'data-testid="{key}"')
        ui.label(f"residual shown below {chosen.cutoff:.3g} Hz").classes("text-sm")


def _traces(trace: Any, span: tuple[float, float] | None) -> dict[str, Any]:
    """Position, speed, torque measured and modelled, and the residual in its ribbon."""
    at = window(trace.time, span)
    time = trace.time[at]
    data = [
        _line(time, trace.position[at], "position", "y4", "#59616b"),
        _line(time, trace.speed[at], "speed", "y3", "#59616b"),
        _line(time, trace.measured[at], "measured", "y2", "#1c2126"),
        _line(time, trace.modelled[at], "modelled", "y2", "#b5480d"),
    ]
    ribbon_time, low, high = thinned_band(time, trace.low[at], trace.high[at])
    ribbon = {
        "type": "scatter",
        "x": [*ribbon_time, *ribbon_time[::-1]],
        "y": [*high, *low[::-1]],
        "fill": "toself",
        "fillcolor": "rgba(43,108,163,0.25)",
        "line": {"width": 0},
        "name": "replicas, 5 to 95 %",
        "yaxis": "y",
        "hoverinfo": "skip",
    }
    data += [ribbon, _line(time, trace.residual[at], "residual", "y", "#b5480d")]
    titles = {"yaxis": "residual", "yaxis2": "torque", "yaxis3": "speed", "yaxis4": "position"}
    domains = {"yaxis": [0, 0.34], "yaxis2": [0.38, 0.66], "yaxis3": [0.7, 0.83], "yaxis4": [0.87, 1]}
    axes = {key: {"title": {"text": titles[key]}, "domain": domains[key]} for key in titles}
    return {
        "data": data,
        "layout": {
            "height": 560,
            "margin": {"l": 70, "r": 10, "t": 10, "b": 40},
            "xaxis": {"title": {"text": "time [s]"}, "anchor": "y"},
            "hovermode": "x unified",
            "legend": {"orientation": "h"},
            **axes,
        },
        "config": {"displaylogo": False, "responsive": True},
    }


def _states(trace: Any, span: tuple[float, float] | None) -> dict[str, Any]:
    """The residual against speed, position, torque and time."""
    at = window(trace.time, span)
    used = np.flatnonzero(trace.used[at]) + at.start
    step = max(1, len(used) // _SCATTER)
    rows = used[::step]
    states = {"speed": trace.speed, "position": trace.position, "torque": trace.measured, "time": trace.time}
    data, layout = [], {"height": 260, "margin": {"l": 60, "r": 10, "t": 10, "b": 40}, "showlegend": False}
    for i, (name, values) in enumerate(states.items(), start=1):
        axis = "" if i == 1 else str(i)
        data.append(
            {
                "type": "scattergl",
                "mode": "markers",
                "x": values[rows].tolist(),
                "y": trace.residual[rows].tolist(),
                "marker": {"size": 3, "color": "#b5480d", "opacity": 0.5},
                "xaxis": f"x{axis}",
                "yaxis": "y",
                "name": name,
            }
        )
        layout[f"xaxis{axis}"] = {"title": {"text": name}, "domain": [(i - 1) / 4 + 0.01, i / 4 - 0.02]}
    layout["yaxis"] = {"title": {"text": "residual"}}
    return {"data": data, "layout": layout, "config": {"displaylogo": False, "responsive": True}}


def _line(time: np.ndarray, values: np.ndarray, name: str, axis: str, colour: str) -> dict[str, Any]:
    t, v = thinned(time, values)
    line = {"color": colour, "width": 1.2}
    return {"type": "scatter", "x": t.tolist(), "y": v.tolist(), "name": name, "yaxis": axis, "line": line}


def _plain(values: np.ndarray) -> list[list[float | None]]:
    return [[None if np.isnan(v) else float(v) for v in row] for row in values]
