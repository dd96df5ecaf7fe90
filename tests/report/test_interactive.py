"""Figures whose library travels compressed: what is unpacked is plotly, and a browser draws them."""

import gzip
import re
from base64 import b64decode

import plotly.graph_objects as go
import pytest

from pyident.report.interactive import element, library


@pytest.fixture
def page(tmp_path):
    figure = go.Figure(go.Bar(x=["</script><b>", "b"], y=[1.0, 2.0]))
    file = tmp_path / "page.html"
    head, body = f"<meta charset='utf-8'>{library()}", element(figure, div_id="bars")
    file.write_text(f"<!doctype html><head>{head}</head><body>{body}", encoding="utf-8")
    return file


def test_the_library_is_whole_and_small(page):
    text = page.read_text("utf-8")
    (packed,) = re.findall(r'id="plotly-gzip">([A-Za-z0-9+/=]+)<', text)
    script = gzip.decompress(b64decode(packed)).decode()
    assert "plotly.js (cartesian - minified)" in script[:200]
    assert "Licensed under the MIT license" in script[:300]
    assert len(text) < 750_000


def test_a_kind_of_figure_that_the_bundle_lacks_is_no_silent_gap():
    with pytest.raises(AssertionError, match="does not draw"):
        element(go.Figure(go.Scatter3d(x=[0], y=[0], z=[0])))


def test_nothing_is_drawn_before_the_library_is_there(page):
    text = page.read_text("utf-8")
    assert text.count("Plotly.newPlot") == text.count("plotlyReady.then(() => {") == 1
    assert "</script><b>" not in text


@pytest.mark.browser
def test_a_browser_draws_it(page, browser):
    shown = browser.new_page()
    shown.goto(page.as_uri())
    shown.wait_for_selector("#bars .barlayer .point", timeout=120_000, state="attached")
    assert shown.locator("#bars .barlayer .point").count() == 2
    shown.close()
