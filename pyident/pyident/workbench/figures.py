"""Plotly figures of the workbench, as plain dictionaries."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pyident.workbench.thinned import thinned, thinned_band, window

EXCESS, INK, GREY, BLUE, GREEN = "#b5480d", "#1c2126", "#59616b", "#2b6ca3", "#2e7d32"
_BARS = {"held out": (EXCESS, GREEN), "fitted": ("#e3ae92", "#9cc79f")}  # before and after
_SCALE = [[0, "#fffaf0"], [0.2, "#fdd9a0"], [0.5, "#f3a14b"], [0.75, "#cf6214"], [1, "#521d02"]]
_SCATTER = 600  # points of a residual against a state
_ORDERS = np.arange(0.5, 40.25, 0.25)  # per turn
Curve = tuple[np.ndarray, str, str]  # values, name, colour


def band_map(bins: Sequence[Any]) -> dict[str, Any]:
    """Equations by bands of frequency: rms over the floor."""
    bins = [b for b in bins if b.kind == "frequency"]
    rows = list(dict.fromkeys(b.coordinate for b in bins))
    labels = list(dict.fromkeys(_band(b) for b in sorted(bins, key=lambda b: b.low)))
    ratio = np.full((len(rows), len(labels)), np.nan)
    for b in bins:
        ratio[rows.index(b.coordinate), labels.index(_band(b))] = b.ratio
    shade = np.log10(np.maximum(ratio, 1.0))
    heat = {
        "type": "heatmap",
        "x": labels,
        "y": rows,
        "z": [[None if np.isnan(v) else float(v) for v in row] for row in shade],
        "text": [["" if np.isnan(v) else f"{float(f'{v:.2g}'):g}" for v in row] for row in ratio],
        "texttemplate": "%{text}",
        "colorscale": _SCALE,
        "zmin": 0,
        "zmax": max(1.0, float(np.nanmax(shade))),
        "showscale": False,
        "hovertemplate": "%{y}, %{x} Hz: %{text} times the floor<extra></extra>",
    }
    layout = {
        "height": 110 + 24 * len(rows),
        "margin": {"l": 90, "r": 10, "t": 60, "b": 20},
        "xaxis": {"side": "top", "fixedrange": True, "automargin": True, "title": {"text": "frequency [Hz]"}},
        "yaxis": {"autorange": "reversed", "fixedrange": True},
    }
    return {"data": [heat], "layout": layout, "config": {"displayModeBar": False, "responsive": True}}


def band_of(bins: Sequence[Any], coordinate: str, label: str) -> tuple[float, float] | None:
    """The band [Hz] of a cell of the map, by its row and column; None where there is no such cell."""
    cells = (b for b in bins if b.kind == "frequency" and b.coordinate == coordinate and _band(b) == label)
    return next(((b.low, b.high) for b in cells), None)


def equation(trace: Any, span: tuple[float, float] | None, bumps: Sequence[Any]) -> dict[str, Any]:
    """Position, speed, deformation, torque measured and modelled, and the residual in its ribbon.

    The last curve is empty: it takes the samples that are brushed.
    """
    at = window(trace.time, span)
    time = trace.time[at]
    panels = [("position", [(trace.position, "position", GREY)]), ("speed", [(trace.speed, "speed", GREY)])]
    if trace.deformation is not None:
        panels.append(("deformation", [(trace.deformation, "deformation", GREY)]))
    panels.append(("force", [(trace.measured, "measured", INK), (trace.modelled, "modelled", EXCESS)]))
    data: list[dict[str, Any]] = []
    layout: dict[str, Any] = {"xaxis": {"title": {"text": "time [s]"}, "anchor": "y"}}
    height = 0.62 / len(panels)
    for i, (title, curves) in enumerate(panels):
        axis, top = f"yaxis{i + 2}", 1 - i * height
        layout[axis] = {"title": {"text": title}, "domain": [top - height + 0.03, top]}
        data += [line(time, v[at], name, colour, f"y{i + 2}") for v, name, colour in curves]
    layout["yaxis"] = {"title": {"text": "residual"}, "domain": [0, 0.36]}
    data += residual(trace, at)
    layout["annotations"] = [
        {"x": (b.start + b.stop) / 2, "y": 0.36, "yref": "paper", "text": str(i), "showarrow": False,
         "bgcolor": EXCESS, "font": {"color": "white", "size": 11}}
        for i, b in enumerate(bumps, start=1)
        if time[0] <= (b.start + b.stop) / 2 <= time[-1]
    ]  # fmt: skip
    layout["shapes"] = [
        {"type": "rect", "x0": max(b.start, time[0]), "x1": min(b.stop, time[-1]), "y0": 0, "y1": 0.36,
         "yref": "paper", "fillcolor": EXCESS, "opacity": 0.08, "line": {"width": 0}, "layer": "below"}
        for b in bumps
        if b.start < time[-1] and b.stop > time[0]
    ]  # fmt: skip
    brushed = {"type": "scatter", "mode": "markers", "x": [], "y": [], "name": "marked", "yaxis": "y",
               "marker": {"size": 5, "color": BLUE}, "showlegend": False}  # fmt: skip
    return _framed([*data, brushed], layout | {"height": 600, "hovermode": "x unified"})


def stretch(trace: Any, span: tuple[float, float] | None, curves: Sequence[Curve]) -> dict[str, Any]:
    """The residual of a stretch in its ribbon, and what laws would make of it."""
    at = window(trace.time, span)
    time = trace.time[at]
    data = [*residual(trace, at), *(line(time, v[at], name, colour, "y") for v, name, colour in curves)]
    axes = {"xaxis": {"title": {"text": "time [s]"}}, "yaxis": {"title": {"text": "residual"}}}
    return _framed(data, axes | {"height": 320, "hovermode": "x unified"})


def residual(trace: Any, at: slice) -> list[dict[str, Any]]:
    """The replicas' ribbon and the residual."""
    time, low, high = thinned_band(trace.time[at], trace.low[at], trace.high[at])
    ribbon = {
        "type": "scatter",
        "x": [*time, *time[::-1]],
        "y": [*high, *low[::-1]],
        "fill": "toself",
        "fillcolor": "rgba(43,108,163,0.25)",
        "line": {"width": 0},
        "name": "replicas, 5 to 95 %",
        "yaxis": "y",
        "hoverinfo": "skip",
    }
    return [ribbon, line(trace.time[at], trace.residual[at], "residual", EXCESS, "y")]


def states(trace: Any, span: tuple[float, float] | None) -> dict[str, Any]:
    """The residual against the state of the joint, its orders of the angle, and against time."""
    at = window(trace.time, span)
    used = np.flatnonzero(trace.used[at]) + at.start
    rows = used[:: max(1, -(-len(used) // _SCATTER))]
    over = {"speed": trace.speed, "position": trace.position}
    if trace.deformation is not None:
        over["deformation"] = trace.deformation
    if np.any(trace.measured):
        over["motor torque"] = trace.measured
    over["time"] = trace.time
    width = 1 / (len(over) + 1)
    data, layout = [], {"height": 280, "showlegend": False, "dragmode": "select"}
    for i, (name, values) in enumerate([*over.items(), ("orders of the angle", None)], start=1):
        axis = "" if i == 1 else str(i)
        domain = [(i - 1) * width + 0.01, i * width - 0.02]
        layout[f"xaxis{axis}"] = {"title": {"text": name}, "domain": domain}
        if values is None:
            layout[f"yaxis{i}"] = {"anchor": f"x{i}", "showticklabels": False, "rangemode": "tozero"}
            x, y = _order_spectrum(trace.position[used], trace.residual[used])
            curve = {"type": "scatter", "mode": "lines", "x": x, "y": y, "name": name}
            data.append(curve | {"xaxis": f"x{i}", "yaxis": f"y{i}", "line": {"color": EXCESS, "width": 1.2}})
            continue
        data.append(
            {
                "type": "scatter",
                "mode": "markers",
                "x": values[rows].tolist(),
                "y": trace.residual[rows].tolist(),
                "marker": {"size": 3, "color": EXCESS, "opacity": 0.5},
                "selected": {"marker": {"color": BLUE, "opacity": 1, "size": 5}},
                "unselected": {"marker": {"opacity": 0.15}},
                "xaxis": f"x{axis}",
                "yaxis": "y",
                "name": name,
            }
        )
    layout["yaxis"] = {"title": {"text": "residual"}}
    return _framed(data, layout)


def waterfall(steps: Sequence[Any]) -> dict[str, Any]:
    """Errors before and after on held-out and fitted data, each over its floor."""
    bars = [
        {"type": "bar", "name": f"{name}, {kind}", "x": [s.name for s in listed],
         "marker": {"color": colour},
         "y": [getattr(s, name) / max(s.floor, 1e-300) for s in listed],
         "text": [f"{getattr(s, name):.3g} {s.unit}" for s in listed]}
        for kind, colours in _BARS.items()
        if (listed := [s for s in steps if s.data == kind])
        for name, colour in zip(("before", "after"), colours, strict=True)
    ]  # fmt: skip
    floor = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 1, "y1": 1, "line": {"dash": "dot"}}
    axis = {"title": {"text": "rms over the floor"}, "rangemode": "tozero"}
    above = {"orientation": "h", "y": 1.0, "yanchor": "bottom"}
    layout = {"height": 320, "yaxis": axis, "shapes": [floor], "barmode": "group", "legend": above}
    layout |= {"xaxis": {"automargin": True}, "margin": {"l": 70, "r": 10, "t": 30, "b": 40}}
    return _framed(bars, layout)


def line(time: np.ndarray, values: np.ndarray, name: str, colour: str, axis: str) -> dict[str, Any]:
    """A curve (N,) over time (N,) [s], thinned."""
    t, v = thinned(time, values)
    style = {"color": colour, "width": 1.2}
    return {"type": "scatter", "x": t.tolist(), "y": v.tolist(), "name": name, "yaxis": axis, "line": style}


def _band(b: Any) -> str:
    return f"{b.low:g}–{b.high:.3g}"


def _order_spectrum(angle: np.ndarray, values: np.ndarray) -> tuple[list[float], list[float]]:
    """Amplitudes of a signal over orders per turn of the angle (N,) [rad]."""
    if not len(values):
        return [], []
    step = max(1, len(values) // 4_000)
    turned = np.exp(-1j * np.outer(_ORDERS, angle[::step]))
    amplitudes = 2 * np.abs(turned @ (values[::step] - values.mean())) / len(values[::step])
    return _ORDERS.tolist(), amplitudes.tolist()


def _framed(data: list[dict[str, Any]], layout: dict[str, Any]) -> dict[str, Any]:
    margin = {"l": 70, "r": 10, "t": 10, "b": 40}
    return {
        "data": data,
        "layout": {"margin": margin, "legend": {"orientation": "h"}, **layout},
        "config": {"displaylogo": False, "responsive": True},
    }
