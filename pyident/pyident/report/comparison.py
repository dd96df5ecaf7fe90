"""The page of a comparison: one file, readable without a server or a network."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
from jinja2 import Environment, PackageLoader
from markupsafe import Markup

from flexmodels.atomic import replacing
from pyident.comparison.bins import Bin
from pyident.comparison.compare import Comparison
from pyident.comparison.errors import Error, LogErrors
from pyident.report.interactive import element, in_script, library
from pyident.report.moving_arm import MovingArm, script
from pyident.report.moving_arm import element as element_of

_KINDS = {
    "frequency": "Frequency",
    "speed": "Speed of the joint",
    "load": "Load on the joint",
    "position": "Position of the joint",
    "direction": "Direction of motion",
    "deformation": "Deformation",
    "time": "Time in the log",
    "log": "Log",
}
_UNKNOWN = Error(np.nan, np.nan, np.nan, "")  # of a model that could not be simulated
_POINTS = 2000  # of a curve
_NUMBERS = 100_000  # in the curves of all signals and logs, half a megabyte


def write_comparison(
    path: Path,
    models: Sequence[str],
    found: Sequence[Comparison],
    notes: Sequence[str] = (),
    arms: Sequence[MovingArm] = (),
) -> Path:
    """Write the page of one model, or of an old and a new one, and return its path.

    arms   of the last model, one per log: the first one is shown
    """
    sections = [("Errors beside their floor", [_waterfall(models, found)])]
    for model, c in zip(models, found, strict=True):
        if not c.bins:  # it could not be simulated: the sentence says so
            continue
        of = f" of {model}" if len(models) > 1 else ""
        sections.append((f"Equations{of}: where they fail", [_map(c), *_bars(c)]))
        sections.append((f"Simulation{of}: what it misses", [_curves(log, _points(c)) for log in c.logs]))
    environment = Environment(loader=PackageLoader("pyident", "report/templates"), autoescape=True)
    html = environment.get_template("comparison.html").render(
        title=" and ".join(models),
        sentences=[(m, c.sentence) for m, c in zip(models, found, strict=True)],
        tracks=found[0].tracks,
        notes=notes,
        plotly=library(),
        arm=Markup(element_of(arms[0], "arm")) if arms else "",
        arm_script=Markup(script()) if arms else "",
        arm_log=Path(arms[0].log).name if arms else "",
        sections=[(title, [_html(f, bool(arms)) for f in figures]) for title, figures in sections],
        tables=[_table(models, found, i) for i in range(len(found[0].logs))],
    )
    with replacing(path) as file:
        file.write_text(html, encoding="utf-8")
    return path


def _html(figure: go.Figure, cursor: bool) -> Markup:
    """cursor: whether curves over time show the moment of the arm."""
    figure.update_layout(template="plotly_white", margin={"l": 60, "r": 20, "t": 50, "b": 50})
    log = figure.layout.meta  # pyright: ignore[reportAttributeAccessIssue]
    if not (cursor and log):
        return element(figure)
    call = f"flexidentCursor(document.getElementById('{{plot_id}}'), {in_script(log)})"
    return element(figure, post_script=call)


def _waterfall(models: Sequence[str], found: Sequence[Comparison]) -> go.Figure:
    """Percent of the signal, per model, beside the floor of the last one."""
    figure = go.Figure()
    several = len(found[0].logs) > 1

    def bars(c: Comparison, floor: bool = False) -> dict[str, list[Any]]:
        told = [(log.log, n, v) for log in c.logs for n, v in _told(log, floor).items()]
        labels = [f"{escape(Path(log).name)} {n}" if several else n for log, n, _ in told]
        return {"x": labels, "y": [v for _, _, v in told]}

    for model, c in zip(models, found, strict=True):
        figure.add_bar(name=escape(model), **bars(c))
    figure.add_bar(name="floor", **bars(found[-1], floor=True), marker={"color": "#bbb"})
    figure.update_layout(title="Error, % of the signal's rms", yaxis={"type": "log", "title": "%"})
    return figure


def _told(log: LogErrors, floor: bool = False) -> dict[str, float]:
    errors = {f"equation {n}": e for n, e in log.equations.items()}
    errors |= {f"simulated {n}": e for n, e in log.simulation.items() if not n.startswith("tip.")}
    return {n: e.floor_percent if floor else e.nrmse_percent for n, e in errors.items()}


def _map(c: Comparison) -> go.Figure:
    """Equation x frequency."""
    bins = [b for b in c.bins if b.kind == "frequency"]
    rows = list(dict.fromkeys(b.coordinate for b in bins))
    columns = list(dict.fromkeys(b.label for b in bins))
    ratio = np.full((len(rows), len(columns)), np.nan)
    for b in bins:
        ratio[rows.index(b.coordinate), columns.index(b.label)] = b.ratio
    text = [["" if np.isnan(v) else f"{v:.2g}" for v in row] for row in ratio]
    names = [f"{n} ({_balance(bins, n)})" for n in rows]
    figure = go.Figure(
        go.Heatmap(
            x=columns,
            y=names,
            z=np.log10(np.maximum(ratio, 1e-3)),
            text=text,
            texttemplate="%{text}",
            colorscale="Reds",
            zmin=0,
            zmax=max(1.0, float(np.nanmax(np.log10(np.maximum(ratio, 1.0))))),
            showscale=False,
        )
    )
    figure.update_layout(title="Times the floor, by equation and frequency", height=160 + 24 * len(rows))
    figure.update_yaxes(autorange="reversed")
    return figure


def _balance(bins: Sequence[Bin], coordinate: str) -> str:
    return next(b.balance for b in bins if b.coordinate == coordinate)


def _bars(c: Comparison) -> list[go.Figure]:
    """One chart per kind of bin; a menu chooses the equation, that of the sentence first."""
    rows = list(dict.fromkeys(b.coordinate for b in c.bins))
    if c.where:
        rows.sort(key=lambda n: n != c.where.coordinate)  # pyright: ignore
    figures = []
    for kind, title in _KINDS.items():
        figure = go.Figure()
        for i, row in enumerate(rows):
            bins = [b for b in c.bins if b.kind == kind and b.coordinate == row]
            words = [
                f"{100 * b.share:.0f} % of the excess, {100 * b.data_share:.0f} % of the data" for b in bins
            ]
            figure.add_bar(
                x=[b.label for b in bins],
                y=[b.ratio for b in bins],
                hovertext=words,
                visible=i == 0,
                name=row,
            )
        buttons: list[dict[str, Any]] = [
            {"label": row, "method": "update", "args": [{"visible": [r == row for r in rows]}]}
            for row in rows
        ]
        figure.update_layout(
            title=f"{title}: times the floor",
            height=340,
            yaxis={"title": "times the floor", "rangemode": "tozero"},
            updatemenus=[{"buttons": buttons, "x": 1.0, "xanchor": "right", "y": 1.25}],
        )
        figure.add_hline(y=1.0, line_dash="dot")
        if any(b.kind == kind for b in c.bins):
            figures.append(figure)
    return figures


def _points(c: Comparison) -> int:
    """Of each curve, so that a page of many logs and joints stays small."""
    return min(_POINTS, _NUMBERS // max(sum(len(log.missed) for log in c.logs), 1))


def _curves(log: LogErrors, points: int) -> go.Figure:
    figure = go.Figure()
    step = max(1, -(-len(log.time) // points))
    began, apart = float(log.time[0]), float(step * (log.time[1] - log.time[0]))
    first = next((n for n in log.missed if n.startswith("tip")), next(iter(log.missed)))
    names = list(log.missed)
    for name, missed in log.missed.items():
        y = np.asarray(missed[::step], np.float32)
        figure.add_scatter(x0=began, dx=apart, y=y, name=name, visible=name == first)
    buttons: list[dict[str, Any]] = [
        {"label": n, "method": "update", "args": [{"visible": [m == n for m in names]}]} for n in names
    ]
    figure.update_layout(
        title=f"{escape(Path(log.log).name)}: log less simulation",
        meta=log.log,
        xaxis={"title": "time, s"},
        yaxis={"title": "m, rad, N m or N"},
        updatemenus=[
            {"buttons": buttons, "active": names.index(first), "x": 1.0, "xanchor": "right", "y": 1.2}
        ],
    )
    return figure


def _cell(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.4g}"


def _table(models: Sequence[str], found: Sequence[Comparison], i: int) -> dict[str, Any]:
    rows = []
    for kind in ("equations", "simulation"):
        told = [getattr(c.logs[i], kind) for c in found]
        for name in dict.fromkeys(n for errors in told for n in errors):
            errors = [t.get(name, _UNKNOWN) for t in told]
            unit = next(t[name].unit for t in told if name in t)
            cells = [_cell(v) for e in errors for v in (e.rmse, e.nrmse_percent, e.ratio)]
            rows.append([kind, name, unit, *cells, _cell(errors[-1].floor_percent)])
    heads = [h for m in models for h in (f"rmse {m}", "% of signal", "times the floor")]
    return {"title": found[0].logs[i].log, "heads": ["", "", "unit", *heads, "floor %"], "rows": rows}
