"""The triangle folded block by block is that of one QR of all rows, however the rows are cut."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pyident.regression.triangle import Triangle

_NUMBERS = st.floats(-1e3, 1e3, allow_subnormal=False).map(lambda x: 0.0 if abs(x) < 1e-6 else x)


@st.composite
def _blocks(draw):
    columns = draw(st.integers(1, 6))
    sizes = draw(st.lists(st.integers(1, 9), min_size=1, max_size=5))
    A = [draw(arrays(float, (rows, columns), elements=_NUMBERS)) for rows in sizes]
    for block in A:  # columns that appear late, or never
        block[:, draw(st.sets(st.integers(0, columns - 1)).map(sorted))] = 0.0
    return A, [draw(arrays(float, rows, elements=_NUMBERS)) for rows in sizes]


@settings(max_examples=40, deadline=None)
@given(_blocks())
def test_normal_equations_are_kept(blocks):
    A, y = blocks
    triangle = Triangle(A[0].shape[1])
    for block, right in zip(A, y, strict=True):
        triangle.fold(block, right)
    whole = np.column_stack([np.vstack(A), np.concatenate(y)])
    R = triangle.full
    size = max(float(np.linalg.norm(whole)), 1.0)
    np.testing.assert_allclose(R.T @ R, whole.T @ whole, atol=1e-12 * size**2)
    assert not np.tril(R, -1)[:-1].any()


def test_small_directions_survive_where_normal_equations_lose_them():
    """Läuchli's matrix: AᵀA has the second column's own part at 1e-18 of its size."""
    tiny = 1e-9
    A = np.array([[1.0, 1.0], [tiny, 0.0], [0.0, tiny]])
    triangle = Triangle(2)
    for row in A:
        triangle.fold(row[None], np.zeros(1))
    singular = np.linalg.svd(triangle.full[:, :2], compute_uv=False)
    np.testing.assert_allclose(singular, [np.sqrt(2 + tiny**2), tiny], rtol=1e-6)
