"""Total least squares: errors in the columns as well as in the torque (Golub and Van Loan 1980).

Right for columns that all have errors of one size; here each has its own, so that it stands for comparison.
"""

from dataclasses import replace

import numpy as np

from pyident.estimation.least_squares import Solution, residual_squares
from pyident.regression.machine.svd import svd
from pyident.regression.reduced import Reduced


def total_least_squares(reduced: Reduced, like: Solution) -> Solution:
    """The solution in the directions and under the weights of a least-squares solution, without intervals."""
    A, y = reduced.stacked(like.weights)
    length = max(float(np.linalg.norm(y)), 1e-300)
    seen = np.column_stack([A / like.scale @ like.seen, y / length])
    smallest = svd(seen)[2][-1]
    p = like.seen @ (-smallest[:-1] / smallest[-1]) * length / like.scale
    residual = np.sqrt(residual_squares(reduced, p) / reduced.samples)
    return replace(like, p=p, residual=residual, covariance=np.full_like(like.covariance, np.nan))
