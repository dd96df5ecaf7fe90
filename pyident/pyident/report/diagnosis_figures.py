"""The two figures of a diagnosis: where the model fails, and what each effect takes away."""

from collections.abc import Sequence
from html import escape
from itertools import pairwise

import numpy as np
import plotly.graph_objects as go
from markupsafe import Markup
from plotly.colors import sample_colorscale

from flexmodels.coordinate import Coordinate
from pyident.diagnosis.result import Diagnosis, Named, Row
from pyident.report.interactive import element
from pyident.report.wording import MINUS, number, times

EXCESS, EXPLAINED, QUIET = "#b5480d", "#2b6ca3", "#59616b"
SCALE = ("#fffaf0", "#fdd9a0", "#f3a14b", "#cf6214", "#8a3305", "#521d02")  # from the floor to the worst
_INK = "#1c2126"
_FONT = {"family": "system-ui, -apple-system, Segoe UI, Roboto, Helvetica, Arial, sans-serif", "color": _INK}
_SIDES = {"motor": "motor", "transmission": "drive"}
_BENDING = {2: "ε₂", 3: "ε₃"}


def row_name(row: Row) -> str:
    """The equation's place in few words: joint and side."""
    index = Coordinate.parse(row.coordinate).index
    return f"{row.joint} {_SIDES.get(row.balance) or 'link ' + _BENDING[index]}"


def band_name(band: tuple[float, float]) -> str:
    """Its edges [Hz], as an axis names them."""
    return f"{band[0]:g}–{band[1]:.3g}"


def heat_map(rows: Sequence[Row]) -> Markup:
    """Rows by frequency bands, coloured by the ratio to the floor on a logarithmic scale."""
    ratio = np.array([row.over_floor for row in rows])
    rms = np.array([row.rms for row in rows])
    used = rms > 0
    shade = np.where(used, np.log10(np.maximum(ratio, 1.0)), np.nan)
    figure = go.Figure(
        go.Heatmap(
            x=[band_name(band) for band in rows[0].bands],
            y=[escape(row_name(row)) for row in rows],
            z=shade,
            zmin=0,
            zmax=_top(float(ratio.max())),
            text=[[_cell(v, u) for v, u in zip(*r, strict=True)] for r in zip(ratio, used, strict=True)],
            customdata=[[number(v) for v in values] for values in rms],
            texttemplate="%{text}",
            hovertemplate="%{y}, %{x} Hz<br>%{text} × the floor<br>rms %{customdata} N m<extra></extra>",
            colorscale=[(i / (len(SCALE) - 1), colour) for i, colour in enumerate(SCALE)],
            showscale=False,
            xgap=2,
            ygap=2,
        )
    )
    figure.update_xaxes(
        title={"text": "frequency [Hz]", "standoff": 16},
        side="top",
        fixedrange=True,
        type="category",
        ticks="",
        tickangle=0,
        showgrid=False,
    )
    figure.update_yaxes(
        autorange="reversed", fixedrange=True, ticks="", type="category", ticksuffix=" ", showgrid=False
    )
    figure.update_traces(textfont_size=11)
    return _embedded(figure, "where-map", 80 + 24 * len(rows))


def colour(ratio: float, highest: float) -> str:
    """The heat map's colour of a ratio to the floor, in a map whose highest ratio is given."""
    share = min(float(np.log10(max(ratio, 1.0))) / _top(highest), 1.0)
    return str(sample_colorscale(list(SCALE), share)[0])


def _top(highest: float) -> float:
    """Where the colour scale ends: small ratios must not look like large ones."""
    return float(np.log10(max(highest, 10.0)))


def waterfall(diagnosis: Diagnosis) -> Markup:
    """From the model as it is, effect by effect, down to the floor."""
    stages = diagnosis.stages
    levels = [stage.over_floor for stage in stages]
    falls = [after - before for before, after in pairwise(levels)]
    names = ["the model as it is", *(f"+ {_effect(s.added)}" for s in stages[1:] if s.added), "what is left"]
    figures = [times(levels[0]), *(f"{MINUS}{times(-fall)}" for fall in falls), times(levels[-1])]
    figure = go.Figure(
        go.Bar(
            orientation="h",
            base=[0, *(min(pair) for pair in pairwise(levels)), 0],
            x=[levels[0], *(abs(fall) for fall in falls), levels[-1]],
            y=list(range(len(names))),
            customdata=[[name, value] for name, value in zip(names, figures, strict=True)],
            hovertemplate="%{customdata[0]}: %{customdata[1]} × the floor<extra></extra>",
            marker={"color": [EXCESS, *(EXPLAINED if fall < 0 else EXCESS for fall in falls), EXCESS]},
            width=0.42,
        )
    )
    for at, level in enumerate(levels):
        figure.add_shape(
            type="line", x0=level, x1=level, y0=at, y1=at + 1, layer="below",
            line={"color": "#aab1b8", "width": 1},
        )  # fmt: skip
    for at, (name, value) in enumerate(zip(names, figures, strict=True)):
        figure.add_annotation(
            x=0, y=at - 0.27, xref="paper", text=f"{escape(name)}  <b>{value}</b>",
            showarrow=False, xanchor="left", yanchor="bottom", xshift=6, font_size=14, bgcolor="white",
        )  # fmt: skip
    figure.add_vline(1, layer="below", line={"color": _INK, "width": 1.5, "dash": "dot"})
    figure.add_annotation(
        x=1, y=len(names) - 0.55, text="floor: 1", showarrow=False, xanchor="left", xshift=5, font_size=12
    )
    figure.update_xaxes(
        rangemode="tozero", title="residual energy, in floors", showgrid=True, gridcolor="#eceff1"
    )
    figure.update_yaxes(range=[len(names) - 0.35, -0.75], visible=False)
    figure.update_xaxes(fixedrange=True, nticks=6)
    figure.update_yaxes(fixedrange=True)
    return _embedded(figure, "waterfall", 70 + 64 * len(names))


def _effect(named: Named) -> str:
    return f"{named.effect} at {named.joint}"


def _cell(ratio: float, used: bool) -> str:
    if not used:
        return ""
    return times(ratio) if ratio >= 99.95 else f"{ratio:.0f}" if ratio >= 9.95 else f"{ratio:.1f}"


def _embedded(figure: go.Figure, name: str, height: int) -> Markup:
    """The figure's element and its call; plotly itself is in the page."""
    figure.update_layout(
        template="none", font=_FONT, font_size=12, height=height, margin={"l": 8, "r": 8, "t": 8, "b": 8},
        paper_bgcolor="rgba(0,0,0,0)", plot_bgcolor="rgba(0,0,0,0)", dragmode=False, showlegend=False,
        hoverlabel={"bgcolor": "white", "font_size": 13},
    )  # fmt: skip
    figure.update_xaxes(automargin=True)
    figure.update_yaxes(automargin=True)
    return element(figure, config={"displayModeBar": False, "responsive": True}, div_id=name)
