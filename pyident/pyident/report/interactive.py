"""Interactive figures in a page that needs nothing else.

The package `plotly` brings five megabytes of JavaScript for fifty kinds of figures. Beside this file lies
the bundle of bars, curves and heat maps that plotly.js publishes (plotly.js-cartesian-dist-min, MIT),
compressed to half a megabyte. A page carries that, and the browser unpacks it (DecompressionStream, in all
browsers since 2023); figures are drawn when it is there.
"""

import json
import re
from base64 import b64encode
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

if TYPE_CHECKING:
    import plotly.graph_objects as go

BUNDLE = "plotly-cartesian.min.js.gz"
KINDS = ("bar", "heatmap", "scatter")  # of traces, which the bundle draws
_UNPACKED = """
const plotlyReady = (async () => {
  const packed = atob(document.getElementById("plotly-gzip").textContent)
  const bytes = Uint8Array.from(packed, letter => letter.charCodeAt(0))
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))
  const script = document.createElement("script")
  script.textContent = await new Response(stream).text()
  document.head.append(script)
})()
plotlyReady.catch(() => document.body.insertAdjacentText("afterbegin",
  "The figures of this page need a browser of 2023 or newer."))
"""
_CALL = re.compile(r"<script[^>]*>(.*?)</script>", re.S)


@cache
def library() -> Markup:
    """The elements of a page's head that `element` relies on."""
    packed = b64encode(files("pyident.report").joinpath("templates", BUNDLE).read_bytes()).decode()
    return Markup(f'<script type="text/plain" id="plotly-gzip">{packed}</script><script>{_UNPACKED}</script>')


def in_script(value: Any) -> str:
    """JSON that may stand in a page's script, whatever text it holds."""
    return json.dumps(value, separators=(",", ":")).replace("<", r"\u003c")


def element(figure: "go.Figure", **options: Any) -> Markup:
    """A figure's place in the page and its call; options as of plotly's `to_html`."""
    other = {trace.type for trace in figure.data} - {*KINDS}
    assert not other, f"the bundle of the page does not draw {other}"
    html = figure.to_html(full_html=False, include_plotlyjs=False, **options)
    return Markup(_CALL.sub(lambda found: f"<script>plotlyReady.then(() => {{{found[1]}}})</script>", html))
