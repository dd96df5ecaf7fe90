"""Hypothesis strategies: files that are almost right, and files that are anything."""

import io
import re
import tomllib

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io
import tomli_w
from hypothesis import strategies as st

NUMBERS = st.one_of(
    st.sampled_from(
        [0.0, -0.0, 1e200, -1e200, 1e-320, float("nan"), float("inf"), -1.0, 1e31, 10**400, 2**63, -1]
    ),
    st.floats(),
    st.integers(),
)
TEXTS = st.one_of(
    st.sampled_from(
        ["", " ", "../x.py", "/etc/passwd", "*/", "</script>", "[/]", "%n%s", "\x1b[2J", "a\nb", "\0"]
    ),
    st.text(max_size=20),
)
VALUES = st.recursive(
    st.one_of(NUMBERS, TEXTS, st.booleans()),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(TEXTS, inner, max_size=3)),
    max_leaves=6,
)


def places(content, at=()):
    """Every place in nested tables and lists."""
    if at:
        yield at
    parts = (
        content.items()
        if isinstance(content, dict)
        else enumerate(content)
        if isinstance(content, list)
        else ()
    )
    for key, part in parts:
        yield from places(part, (*at, key))


@st.composite
def changed_toml(draw, text):
    """The text of a TOML file with some of its values replaced, removed or added, or some of its bytes."""
    if draw(st.integers(0, 4)) == 0:
        return draw(changed_bytes(text.encode()))
    content = tomllib.loads(text)
    for _ in range(draw(st.integers(1, 3))):
        *above, key = draw(st.sampled_from(list(places(content))))
        inside = content
        for step in above:
            inside = inside[step]
        what = draw(st.sampled_from(["replace", "replace", "remove", "add"]))
        if what == "remove":
            del inside[key]
        elif what == "replace" or isinstance(inside, list):
            inside[key] = draw(VALUES)
        else:
            inside[draw(TEXTS)] = draw(VALUES)
        if not list(places(content)):
            break
    try:
        return tomli_w.dumps(content).encode("utf-8", "surrogatepass")
    except (TypeError, ValueError):  # what TOML cannot say
        return draw(st.binary(max_size=200))


@st.composite
def changed_bytes(draw, content):
    """Bytes with a piece cut out, doubled or replaced by anything."""
    if draw(st.integers(0, 5)) == 0:
        return draw(st.binary(max_size=300))
    start = draw(st.integers(0, max(0, len(content) - 1)))
    stop = min(len(content), start + draw(st.integers(0, 40)))
    middle = draw(st.one_of(st.binary(max_size=12), st.just(content[start:stop] * 2)))
    return content[:start] + middle + content[stop:]


@st.composite
def changed_xml(draw, text):
    """XML with some of what stands between quotes replaced, or some of its bytes."""
    if draw(st.booleans()):
        return draw(changed_bytes(text.encode()))
    parts = text.replace('"', "'").split("'")
    for _ in range(draw(st.integers(1, 3))):
        at = 2 * draw(st.integers(0, len(parts) // 2 - 1)) + 1
        parts[at] = draw(st.one_of(WORDS, st.text("0123456789.-e ab", max_size=8)))
    return "'".join(parts).encode()


WORDS = st.sampled_from(
    ["nan", "inf", "-1", "1e400", "0 0 0", "0 0", "a", "b", "world", "", "fixed", "&#10;"]
)
CELLS = st.one_of(
    st.floats(-2, 2).map(repr),
    st.sampled_from(["nan", "inf", "1e200", "-1e308", "", "a", "0", "1e-300", "٣", '"', "\0"]),
)


@st.composite
def columns(draw, names):
    """Name and cells of columns, of which some are wrong: constant, wild, words, missing or named twice."""
    rows = draw(st.integers(0, 12))
    kept = [name for name in names if draw(st.integers(0, 9))] + draw(st.lists(TEXTS, max_size=1))
    out = []
    for name in kept:
        kind = draw(st.sampled_from(["time", "zero", "wild", "line"]))
        if name == "time" and kind != "wild":
            cells = [repr(0.01 * i) for i in range(rows)]
        elif kind == "wild":
            cells = [draw(CELLS) for _ in range(rows)]
        else:
            cells = [repr(0.0 if kind == "zero" else 0.1 * i) for i in range(rows)]
        out.append((name, cells))
    return out


@st.composite
def tables(draw, names):
    """CSV of such columns."""
    listed = draw(columns(names))
    lines = [
        ",".join(n for n, _ in listed),
        *(",".join(row) for row in zip(*(c for _, c in listed), strict=True)),
    ]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


@st.composite
def parquets(draw, names):
    """Parquet of such columns, numbers or words; sometimes with bytes changed."""
    listed = [(n, _numbers(cells)) for n, cells in draw(columns(names))]
    arrays = [pa.array(cells) for _, cells in listed]
    sink = io.BytesIO()
    pq.write_table(
        pa.Table.from_arrays(arrays, [n.encode("utf-8", "replace").decode() for n, _ in listed]), sink
    )
    return draw(changed_bytes(sink.getvalue())) if draw(st.integers(0, 2)) == 0 else sink.getvalue()


@st.composite
def mats(draw, names):
    """MAT of such columns, some of them matrices, cells or structures; sometimes with bytes changed."""
    content = {}
    for name, cells in draw(columns(names)):
        shape = draw(st.sampled_from(["column", "row", "column", "matrix", "struct", "text"]))
        values = np.array([v if isinstance(v, float) else np.nan for v in _numbers(cells)])
        shaped = {
            "column": values[:, None],
            "row": values[None],
            "matrix": np.tile(values, (3, 1)),
            "text": name,
        }
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:31].lstrip("_0123456789") or "x"
        content[plain] = {"signals": values} if shape == "struct" else shaped[shape]
    sink = io.BytesIO()
    scipy.io.savemat(sink, content)
    return draw(changed_bytes(sink.getvalue())) if draw(st.integers(0, 2)) == 0 else sink.getvalue()


def _numbers(cells):
    """As floats where all of them are numbers, else as they are."""
    try:
        return [float(cell) for cell in cells]
    except ValueError:
        return [cell.encode("utf-8", "replace").decode() for cell in cells]
