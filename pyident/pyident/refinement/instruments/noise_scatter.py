"""Covariance of an instrumental estimate: the noise of the sensors, carried through the equations.

Noise n of a sensor enters an equation as A n̈ + B ṅ + C n with A, B, C the derivatives of Φ p, each through
the same stencil as the signal. Summed against instruments it is a sum over the noise itself, sample by
sample, of instruments that went through the stencils backwards: no lag is cut off and no spectrum smoothed.
The loop does not enter: what noise does to the torque, the logged torque tells, and the motion answers to it.
"""

from collections.abc import Mapping

import numpy as np

from flexmodels.robot import Robot
from flexmodels.threads import gathered
from pyident.conditioning.motion import Motion
from pyident.conditioning.samples import Conditioned
from pyident.conditioning.weak_form import REACH, derivatives_of
from pyident.estimation.instrumental_variables import Rows
from pyident.regression.regressor import generalised_forces

_STEP = 1e-6  # rad, rad/s: finite differences of Φ p


def noise_scatter(
    robot: Robot,
    part: Conditioned,
    rows: Rows,
    p: np.ndarray,
    weights: np.ndarray,
    turn: np.ndarray,
    noise: Mapping[str, float],
    period: float,
) -> np.ndarray:
    """(r, r) covariance of the sums of instrument times residual in a log; noise: channel -> std."""
    U = np.array(
        [w**2 * rows.share[:, c, None] * rows.turned(c, turn).T for c, w in enumerate(weights)]
    )  # (n, N, r)
    stencils, base = _stencils(robot, period), generalised_forces(robot, part.motion, p)

    def of_coordinate(j: int) -> np.ndarray:
        back = np.zeros((U.shape[1] + 2 * REACH, turn.shape[1]))
        for field, stencil in stencils.items():
            slope = _slope(robot, part.motion, field, j, p, base)
            driven = np.einsum("nc,cnr->nr", slope, U, optimize=True)
            for offset, weight in enumerate(stencil):
                if weight:
                    back[offset : offset + len(driven)] += weight * driven
        return noise[robot.coordinates[j]] ** 2 * back.T @ back

    noisy = [j for j, name in enumerate(robot.coordinates) if noise.get(name, 0.0) > 0]
    total = np.zeros((turn.shape[1], turn.shape[1])) + sum(gathered(of_coordinate, noisy))
    for k, _ in robot.numbered:
        sigma = noise.get(f"joint{k}.tau", 0.0)
        if sigma:
            held = part.motion.tau_before is not None
            torque = (U[k - 1][1:] + U[k - 1][:-1]) / 2 if held else U[k - 1]
            total += sigma**2 * torque.T @ torque
    return total


def _stencils(robot: Robot, period: float) -> dict[str, np.ndarray]:
    """Field of the motion -> weights of the samples from REACH before to REACH after."""
    impulses = np.eye(2 * REACH + 1)
    fields = zip(("q", "dq", "ddq"), derivatives_of(robot)(impulses, period), strict=True)
    return {field: values[0] for field, values in fields}


def _slope(robot: Robot, motion: Motion, field: str, j: int, p: np.ndarray, base: np.ndarray) -> np.ndarray:
    """(N, n) derivative of Φ p along coordinate j of a field, per unit of what the stencil gives."""
    values = getattr(motion, field).copy()
    values[:, j] += _STEP if field != "ddq" else 1.0
    changed = Motion(**{**vars(motion), field: values})
    return (generalised_forces(robot, changed, p) - base) / (_STEP if field != "ddq" else 1.0)
