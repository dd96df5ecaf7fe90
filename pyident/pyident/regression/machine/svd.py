"""Singular values of any matrix: LAPACK's faster algorithm gives up on some that have no full rank."""

import numpy as np


def svd(matrix: np.ndarray, full: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """U (m, k), s (k,), Vt (k, n) with k = min(m, n), or square U and Vt where `full`.

    By divide and conquer (gesdd), and by the QR algorithm (gesvd) where that does not converge.
    """
    try:
        return np.linalg.svd(matrix, full_matrices=full)
    except np.linalg.LinAlgError:
        import scipy.linalg

        return scipy.linalg.svd(matrix, full_matrices=full, lapack_driver="gesvd")
