"""Masses of a written model that no body near a prior's explains.

Masses of single links are seldom determined: what sets them are the bodies that can exist and do as the data
ask. Where none does, the model lacks an effect, and a mass of six times the prior's is that effect in
disguise. Then the prior's masses hold within a factor, if the model predicts nearly as well so. Where bodies
do as the data ask, the masses are what the data say, however far from the prior's: a payload, say.
"""

from collections.abc import Callable

import numpy as np

from flexmodels.robot import Robot
from pyident.estimation.least_squares import Solution
from pyident.estimation.physical import consistent, misfit
from pyident.regression.reduced import Reduced

ALIKE = 2.0  # a mass further from its prior's is worth a word
_DISAGREES = 0.95  # quantile of chi-squared above which bodies do not do as the data ask
_WORSE = 1.25  # of the error: what masses of the prior's size may cost


def unlike(written: dict[str, float], prior: Robot) -> dict[str, float]:
    """Masses of the prior [kg] that the written model misses by more than ALIKE."""
    masses = {f"link{k}.m": link.m for k, link in enumerate(prior.links, start=1) if link.m > 0}
    return {name: m for name, m in masses.items() if not 1 / ALIKE <= written[name] / m <= ALIKE}


def held_masses(
    robot: Robot,
    reduced: Reduced,
    solution: Solution,
    prior: Robot,
    p: np.ndarray,
    error: Callable[[np.ndarray], float],
) -> tuple[np.ndarray, str | None]:
    """The written model's parameters (P,), and a sentence where masses are or could be held near the prior's.

    p       those with free masses
    error   of parameters, by which the written model is judged [%]
    """
    from scipy.stats import chi2

    free = dict(zip(reduced.columns, p.tolist(), strict=True))
    far = unlike(free, prior)
    if not far or misfit(reduced, solution, p, prior) <= chi2.ppf(_DISAGREES, solution.rank) / solution.rank:
        return p, None
    held = consistent(robot, reduced, solution, prior, 0.999 * ALIKE)
    before, after = error(p), error(held)
    if after > _WORSE * before:
        return p, (
            f"masses within a factor of {ALIKE:g} of those of {prior.name} would leave {after:.3g} % of "
            f"error in place of {before:.3g} %: the model lacks an effect, or the prior is of another arm"
        )
    named = ", ".join(f"{name} ({free[name]:.3g} kg if free, there {m:.3g})" for name, m in far.items())
    return held, (
        f"no bodies that can exist do as the data ask, so that the masses are held within a factor of "
        f"{ALIKE:g} of those of {prior.name}: {named}; that costs {after:.3g} % of error in place of "
        f"{before:.3g} %"
    )
