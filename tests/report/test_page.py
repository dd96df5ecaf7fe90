"""A page carries all that it shows, and text stays text."""

import base64
import re

import matplotlib

matplotlib.use("Agg")
import pandas as pd
from matplotlib.figure import Figure

from pyident.report.page import Picture, Section, write_page


def test_a_page_needs_nothing_else(tmp_path):
    figure = Figure()
    figure.add_subplot().plot([0, 1], [0, 1])
    table = pd.DataFrame({"what": ["<b>tip</b>"], "value": [1.5]})
    sections = [Section("First & last", "a < b", [Picture(figure, "A line.")], table)]
    text = write_page(tmp_path / "page.html", "Title", "Summary.", sections).read_text("utf-8")
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    (image,) = re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", text)
    assert base64.b64decode(image).startswith(b"\x89PNG")
    assert "First &amp; last" in text
    assert "a &lt; b" in text
    assert "<b>tip</b>" not in text
    assert "A line." in text


def test_a_figure_may_be_left_out(tmp_path):
    text = write_page(tmp_path / "page.html", "Title", "", [Section("Only text", "said")]).read_text("utf-8")
    assert "Only text" in text
    assert "base64" not in text
