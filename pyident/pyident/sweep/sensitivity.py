"""Which parameters a result depends on: Morris' screening and Sobol's indices, by SALib.

Each takes a design of its own, made here, and the results in the design's order. Failed runs (not finite)
are left out with the whole trajectory or block that they belong to.
"""

from importlib.util import find_spec
from typing import Any, Literal

import numpy as np
import pandas as pd

from pyident.sweep.sampling import Ranges
from pyident.sweep.store import StudyError

Method = Literal["morris", "sobol_indices"]
_LEVELS = 4  # of Morris' grid


def morris_design(ranges: Ranges, runs: int, seed: int = 0) -> pd.DataFrame:
    """Trajectories through a grid that change one parameter at a time; at least `runs` sets.

    Morris, Technometrics 33 (1991) 161. Raises StudyError without SALib.
    """
    _require_salib()
    from SALib.sample import morris

    trajectories = max(2, -(-runs // (len(ranges) + 1)))
    return _frame(morris.sample(_problem(ranges), trajectories, _LEVELS, seed=seed), ranges)


def sobol_indices_design(ranges: Ranges, runs: int, seed: int = 0) -> pd.DataFrame:
    """Saltelli's scheme for first-order and total indices: blocks of parameters + 2; at least `runs` sets.

    Saltelli et al., Computer Physics Communications 181 (2010) 259. Raises StudyError without SALib.
    """
    _require_salib()
    from SALib.sample import sobol

    blocks = -(-runs // (len(ranges) + 2))
    base = 2 ** max(1, int(np.ceil(np.log2(blocks))))
    return _frame(sobol.sample(_problem(ranges), base, calc_second_order=False, seed=seed), ranges)


def sensitivity(method: Method, ranges: Ranges, design: pd.DataFrame, result: np.ndarray) -> pd.DataFrame:
    """One row per parameter.

    design, result   as `morris_design` or `sobol_indices_design` made it; (N,), one number per set
    morris           mu, mu_star, sigma, mu_star_conf: effect of the whole range, in the result's unit
    sobol_indices    S1, S1_conf, ST, ST_conf: shares of the variance (conf: 95 %)
    Raises StudyError when fewer than two trajectories or blocks are whole, or without SALib.
    """
    _require_salib()
    size = len(ranges) + (1 if method == "morris" else 2)
    y = np.asarray(result, dtype=float).reshape(-1, size)
    whole = np.isfinite(y).all(axis=1)
    if whole.sum() < 2:
        raise StudyError(f"{method} needs two full groups of {size} runs, but only {whole.sum()} succeeded")
    x = design[list(ranges)].to_numpy(dtype=float).reshape(len(y), size, -1)[whole].reshape(-1, len(ranges))
    return _analysed(method, _problem(ranges), x, y[whole].ravel(), list(ranges))


def _analysed(
    method: Method, problem: dict[str, Any], x: np.ndarray, y: np.ndarray, names: list[str]
) -> pd.DataFrame:
    from SALib.analyze import morris, sobol

    if method == "morris":
        found, columns = morris.analyze(problem, x, y, num_levels=_LEVELS, seed=0), ("mu", "mu_star", "sigma")
        columns = (*columns, "mu_star_conf")
    else:
        found = sobol.analyze(problem, y, calc_second_order=False, seed=0)
        columns = ("S1", "S1_conf", "ST", "ST_conf")
    return pd.DataFrame({c: np.asarray(found[c], dtype=float) for c in columns}, index=names)


def _problem(ranges: Ranges) -> dict[str, Any]:
    return {"num_vars": len(ranges), "names": list(ranges), "bounds": [list(r) for r in ranges.values()]}


def _frame(points: np.ndarray, ranges: Ranges) -> pd.DataFrame:
    return pd.DataFrame(points, columns=list(ranges))


def _require_salib() -> None:
    if find_spec("SALib") is None:
        raise StudyError("SALib is missing, which computes sensitivities; pip install 'flexident[study]'")
