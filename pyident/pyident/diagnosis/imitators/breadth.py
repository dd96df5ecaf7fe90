"""Whether a law's gain rests on a sliver of the samples, away from where the law acts.

Near rest friction is nobody's law: asperities bend, other simulators round the sign, a joint turns back
between two samples. A few samples in a hundred may then hold most of what a model leaves, and some law of
another thing can be bent until it fits just these: a coupling with a ratio of nearly nothing is Coulomb
friction with a round sign. Such a law acts in all samples and explains a few. So the samples in which the
joint is slowest, and those in which it is fastest, are left out in turn, with everything fitted again to the
rest (a jackknife by blocks, Künsch 1989). A law that loses most of its gain by that, but next to nothing of
its own force, is not what explains them. Presliding, Stribeck and others that act near rest keep their name:
they lose the force as well.

A true law may differ from the others hardly anywhere else: friction that grows with the square of the speed
at full speed, the constant torque of a joint that moves now and then where it turns back. Then a law has to
hold what its own coefficients promise of the rest; and beside the slowest samples, where the excuse is at
hand, the rest must show it beyond chance by itself.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodels.robot import Robot
from pyident.conditioning.fading import fading
from pyident.diagnosis.base.candidates import Candidate, bounds, columns
from pyident.diagnosis.base.projection import (
    Base,
    extended,
    fall_per_row,
    gain,
    gains_over,
    others_of,
    solve_base,
)
from pyident.diagnosis.imitators.constancy import QUANTITIES
from pyident.diagnosis.search.search import Search
from pyident.regression.spectrum import Equations, all_over, equations
from pyident.rules.search import SearchRules

_BLOCKS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "slowest": lambda speed: -speed,
    "fastest": lambda speed: speed,
}


def rests_on(search: Search, candidate: Candidate) -> str:
    """The few samples that a candidate's gain rests on though it acts elsewhere, in words; empty: on none.

    The search must rest on the candidate and all others that are named.
    """
    if candidate.log is not None:
        return ""  # of a body every sample tells alike
    without = search.without(candidate)
    logs, levels = search.examination.logs, search.levels
    return block_of(search.robot, logs, levels, without.base, without.chosen, candidate, search.rules)


def block_of(
    robot: Robot,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    base: Base,
    others: Sequence[Candidate],
    candidate: Candidate,
    rules: SearchRules,
) -> str:
    """As `rests_on`, of a law beside `others`. logs: whitened with levels, (n, E) each; base: of both."""
    X = columns(robot, candidate, logs, levels)
    whole = gain(base, X, *bounds(robot, candidate))
    joint = robot.q[int(np.argmax(fall_per_row(base, X)))].joint
    speed = [QUANTITIES["speed"](robot, log, joint - 1) for log in logs]
    used = [log.part.use[:, joint - 1] > 0 for log in logs]
    for name, quantity in _BLOCKS.items():
        by_sample = [quantity(v) for v in speed]
        listed = np.concatenate([x[u] for x, u in zip(by_sample, used, strict=True)])
        limit = float(np.quantile(listed, 1 - rules.block))
        kept = [(x <= limit).astype(float) for x in by_sample]
        if _force_left(robot, logs, levels, candidate, whole.coefficients, kept) < 1 - rules.block_force:
            continue  # it acts there
        rest = _without(robot, logs, levels, kept)
        explained, promised = _explained(robot, rest, levels, others, candidate, whole.coefficients)
        excused = name == "fastest" or explained > rules.chance**2
        needed = min(whole.energy, promised) if excused else whole.energy
        if explained < (1 - rules.block_gain) * needed:
            return f"the {100 * rules.block:.0f} % {name} samples of joint {joint}"
    return ""


def _explained(
    robot: Robot,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    others: Sequence[Candidate],
    candidate: Candidate,
    coefficients: np.ndarray,
) -> tuple[float, float]:
    """Energy that a law takes beside others, and what it would take with these coefficients (K,) if true."""
    base = solve_base(logs)
    for other in others:
        base = extended(base, columns(robot, other, logs, levels))
    X, limits = columns(robot, candidate, logs, levels), bounds(robot, candidate)
    force = [np.zeros_like(r) for r in base.residual]
    for own, rows in zip(force, X, strict=True):
        for row, x in rows.items():
            own[row] = x @ coefficients
    (promised,) = gains_over(base, X, others_of(base, [force]), *limits)
    return gain(base, X, *limits).energy, promised


def _without(
    robot: Robot, logs: Sequence[Equations], levels: Sequence[np.ndarray], kept: Sequence[np.ndarray]
) -> list[Equations]:
    """The logs' equations with samples left out, on all rows; kept: per log (N,), 0 where it is left out."""
    parts = [
        replace(log.part, use=log.part.use * fading(keep[:, None]))
        for log, keep in zip(logs, kept, strict=True)
    ]
    made = equations(robot, parts, [log.band.period for log in logs])
    return all_over(made, levels)


def _force_left(
    robot: Robot,
    logs: Sequence[Equations],
    levels: Sequence[np.ndarray],
    candidate: Candidate,
    coefficients: np.ndarray,
    kept: Sequence[np.ndarray],
) -> float:
    """Share of a law's own force, over the floor on the equation where it is largest, in the samples kept.

    Over the floor, as its gain is: a ripple of one amplitude is fast where the joint is, and there the floor
    may be low.
    """
    whole, left = (
        [_energies(X, coefficients) for X in columns(robot, candidate, logs, levels, acting)]
        for acting in (None, kept)
    )
    total = {row: sum(log.get(row, 0.0) for log in whole) for row in {row for log in whole for row in log}}
    row = max(total, key=lambda row: total[row])
    return sum(log.get(row, 0.0) for log in left) / max(total[row], 1e-300)


def _energies(X: Mapping[int, np.ndarray], coefficients: np.ndarray) -> dict[int, float]:
    """Row -> energy of a law's force in one log."""
    return {row: float(np.square(x @ coefficients).sum()) for row, x in X.items()}
