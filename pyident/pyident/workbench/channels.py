"""The channels of one file, in memory as long as the page looks at them."""

from pathlib import Path
from typing import Any

import numpy as np

from pyident.workbench.thinned import thinned, window

_POINTS = 1_000  # of a channel
_MOST = 12  # channels of a figure
_COLOUR = "#2b6ca3"


class Channels:
    """What a file holds. path: of the file;  time (N,);  columns: name -> (N,)."""

    def __init__(self, path: str):
        from pyident.verbs.recordings import channels_of

        self.path = path
        self.changed = Path(path).stat().st_mtime_ns
        self.time, self.columns = channels_of(path)

    def is_of(self, path: str) -> bool:
        """Whether these are the channels of a file as it is now."""
        return path == self.path and Path(path).stat().st_mtime_ns == self.changed

    def figure(self, span: tuple[float, float] | None = None) -> dict[str, Any]:
        """Every channel over a span of time, one above the other."""
        names = list(self.columns)[:_MOST]
        at = window(self.time, span)
        data, layout = [], {"height": 60 + 80 * len(names), "showlegend": False}
        share = 1 / max(len(names), 1)
        for i, name in enumerate(names, start=1):
            t, v = thinned(self.time[at], self.columns[name][at], _POINTS)
            axis = "y" if i == 1 else f"y{i}"
            style = {"color": _COLOUR, "width": 1}
            data.append(
                {
                    "type": "scatter",
                    "x": _listed(t),
                    "y": _listed(v),
                    "yaxis": axis,
                    "name": name,
                    "line": style,
                }
            )
            top = 1 - (i - 1) * share
            title = {"text": name, "font": {"size": 10}}
            layout["yaxis" if i == 1 else f"yaxis{i}"] = {"title": title, "domain": [top - 0.85 * share, top]}
        layout["xaxis"] = {
            "title": {"text": "time [s]"},
            "anchor": f"y{len(names)}" if len(names) > 1 else "y",
        }
        layout["margin"] = {"l": 90, "r": 10, "t": 10, "b": 40}
        return {"data": data, "layout": layout, "config": {"displaylogo": False, "responsive": True}}


def _listed(values: np.ndarray) -> list[float | None]:
    return [float(v) if np.isfinite(v) else None for v in values]
