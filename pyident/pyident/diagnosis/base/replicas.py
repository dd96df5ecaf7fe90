"""Replicas, logs that the fitted model itself would have made, and what a regression leaves of them.

What is left depends on the weights. The noise of encoders, which differences amplify, is in the columns too;
with one weight for all frequencies it bends the parameters at high ones. What that leaves at low ones would
be a floor that drowns the physics there: of flexible robots a hundred times what the right parameters leave.
"""

from collections.abc import Sequence

import numpy as np

from pyident.diagnosis.base.discrepancy import inexact
from pyident.diagnosis.base.projection import residuals_of
from pyident.diagnosis.base.setting import Setting, replicas_of
from pyident.logs.log import Log
from pyident.regression.spectrum import Band, Equations, all_over, floors, levels_of
from pyident.simulation.denoised import denoised_equations, denoises
from pyident.simulation.replica import Repeat
from pyident.simulation.simulator import Simulator

_WEIGHTINGS = 2  # rounds, after which a floor changes by less than a per cent


def replicated(
    fmu: Simulator, setting: Setting, seeds: Sequence[int]
) -> list[tuple[list[Log], list[Band], list[np.ndarray]]]:
    """Per replica its logs, their bands and what is left of each, (n, E) [N m].

    Of simulated ones the parameters are known: what these leave is the noise of each equation, in its
    residual and in its columns. Along a measured motion they are drawn, and a regression tells. Of a fit that
    cannot be simulated there is the noise alone.
    """
    if setting.unfollowed:
        return [_of_noise(setting, seed) for seed in seeds]
    left = _left_by_own if setting.simulates else left_of
    return [(made, *left(setting, made)) for made in judged_replicas(fmu, setting, seeds)]


def _of_noise(setting: Setting, seed: int) -> tuple[list[Log], list[Band], list[np.ndarray]]:
    """The setting's logs with noise once more, and what that changes of what the regression leaves."""
    share, made = setting.rules.replicas.inexact, []
    for i, again in enumerate(r for r in setting.repeats if isinstance(r, Repeat)):
        noise = {**setting.noise, **setting.own_noise.get(again.log.source, {})}
        number = len(setting.repeats) * seed + i
        made.append(inexact(setting.robot, again.noisier(noise, number), share, number))
    found, own = (denoised_equations(setting.robot, logs) for logs in (made, setting.logs))
    p = setting.solution.p
    pairs = zip(found, own, strict=True)
    return made, [e.band for e in found], [(e.y - e.A @ p) - (o.y - o.A @ p) for e, o in pairs]


def judged_replicas(fmu: Simulator, setting: Setting, seeds: Sequence[int]) -> list[list[Log]]:
    """Logs as the setting's robot would have made them, per seed, with what no model is exact to."""
    share, count = setting.rules.replicas.inexact, len(setting.repeats)
    return [
        [inexact(setting.robot, log, share, count * seed + i) for i, log in enumerate(made)]
        for seed, made in zip(seeds, replicas_of(fmu, setting, setting.repeats, seeds), strict=True)
    ]


def _left_by_own(setting: Setting, logs: Sequence[Log]) -> tuple[list[Band], list[np.ndarray]]:
    """Per log its band and what the parameters of the setting's robot leave there, (n, E) [N m]."""
    found = denoised_equations(setting.robot, logs)
    p = np.array(list(setting.robot.linear_parameters.values()))
    return [e.band for e in found], [e.y - e.A @ p for e in found]


def left_of(setting: Setting, logs: Sequence[Log]) -> tuple[list[Band], list[np.ndarray]]:
    """Per log its band and what the regression leaves there, (n, E) [N m].

    Where the motion is without its noise, the weights are of what the log leaves at each frequency, found in
    rounds.
    """
    flat = 1 / np.maximum(setting.solution.weights, 1e-300)
    found = denoised_equations(setting.robot, logs)
    levels: list[np.ndarray] = [flat[:, None]] * len(found)
    if denoises(setting.robot):
        levels = levels_by_rest(found, levels)
    return [e.band for e in found], _left_over(found, levels)


def levels_by_rest(data: Sequence[Equations], levels: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Per log (n, E) what a regression of equations leaves at each frequency, in rounds from levels on."""
    found = list(levels)
    for _ in range(_WEIGHTINGS):
        found = levels_of(floors([e.band for e in data], _left_over(data, found), len(data)), data)
    return found


def _left_over(data: Sequence[Equations], levels: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Per log (n, E) what a regression over levels leaves, itself not over them."""
    return [r * at for r, at in zip(residuals_of(all_over(data, levels)), levels, strict=True)]
