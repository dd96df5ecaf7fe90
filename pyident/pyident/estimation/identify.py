"""Robot + logs -> identified robot: conditioning, regression, physical consistency."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.robot import Robot, RobotError
from pyident.conditioning.windows import prepared
from pyident.estimation.base_parameters import BaseParameter, Support, base_parameters, supports
from pyident.estimation.estimator import Estimator, weighted
from pyident.estimation.held_masses import ALIKE, held_masses, unlike
from pyident.estimation.least_squares import Solution, residual_squares
from pyident.estimation.physical import consistent, lower_bounds
from pyident.logs.disk import LogFile
from pyident.logs.log import Log, LogError
from pyident.regression.equations import Problem
from pyident.regression.reduced import Reduced
from pyident.rules.confidence import CONFIDENCE, LEVEL

_NOTHING = 1e-3  # of what the solution says: so near to a bound a parameter is at it
_WORST = 3  # disagreements that are named
_IMPOSSIBLE = 5.0  # standard deviations below zero
_POSITIVE = (".m", ".J[xx]", ".J[yy]", ".J[zz]", ".J_m", ".coulomb", ".viscous")


@dataclass(frozen=True)
class Identified:
    """The outcome: the robot with its new parameters and how well the data support them.

    relative_error   100 |y - A p| / |y| of the motor torques, per joint and over all [%]; nan of a joint
                     whose equation is never in use, as it stands still
    estimator        by which the values were found
    notes            what its user must know, a sentence each
    """

    robot: Robot
    reduced: Reduced
    solution: Solution
    support: dict[str, Support]
    base: list[BaseParameter]
    relative_error: dict[str, float]
    estimator: str = "weighted least squares"
    notes: tuple[str, ...] = ()

    @property
    def model_error(self) -> dict[str, float] | None:
        """`relative_error` of the robot's own parameters, which are physically consistent.

        None where the solution is of outputs of a simulation instead of equations of motion.
        """
        if self.reduced.rows != self.robot.coordinates:
            return None
        p = np.array([self.robot.parameters[name] for name in self.reduced.columns])
        return relative_error(self.reduced, p, len(self.robot.joints))

    @property
    def at_bound(self) -> list[str]:
        """Parameters of the written model at their least value; the data ask for less beyond chance."""
        values, bounds = self.robot.parameters, lower_bounds(self.robot)
        chance = np.where(np.isfinite(self.solution.std), CONFIDENCE * self.solution.std, 0.0)
        most = dict(zip(self.reduced.columns, self.solution.p + chance, strict=True))
        return [
            name
            for name, bound in bounds.items()
            if self.support.get(name) == "alone"
            and values[name] - bound <= _NOTHING * abs(most[name] - bound)
            and most[name] < bound
        ]

    def json(self) -> dict[str, Any]:
        """The contract of `identify --json`."""
        units, values = self.robot.units, self.robot.parameters
        return {
            "estimator": self.estimator,
            "parameters": {
                name: {
                    "value": values[name],
                    "std": finite(self.solution.std[i]),
                    "unit": units[name],
                    "identifiable": self.support[name],
                }
                for i, name in enumerate(self.reduced.columns)
            },
            "base_parameters": [
                {"expression": b.expression, "value": b.value, "std": finite(b.std)} for b in self.base
            ],
            "rank": self.solution.rank,
            "relative_error_percent": told_errors(self.relative_error),
            "relative_error_of_model_percent": self.model_error and told_errors(self.model_error),
        }


def identify(robot: Robot, logs: Sequence[Log | LogFile], estimator: Estimator = weighted) -> Identified:
    """Identify every dynamic parameter of `robot` from its logs; its own values are never used.

    Logs on disk are gone through a few times, window by window, and never are in memory as a whole.

    Raises LogError for logs that cannot be used.
    """
    problem = Problem(robot, tuple(prepared(log, robot) for log in logs))
    found = estimator(problem).with_long_memory()
    return identified(robot, found.reduced, found.solution)


def identified(robot: Robot, reduced: Reduced, solution: Solution) -> Identified:
    """Name and judge a solution; the robot gets the physically consistent parameters nearest to it."""
    p = consistent(robot, reduced, solution)
    name = robot.name if robot.name.endswith("_identified") else f"{robot.name}_identified"
    return Identified(
        robot=robot.with_parameters(dict(zip(reduced.columns, p, strict=True)), name),
        reduced=reduced,
        solution=solution,
        support=supports(reduced, solution),
        base=base_parameters(reduced, solution),
        relative_error=relative_error(reduced, solution.p, len(robot.joints)),
    )


def of_the_same_arm(prior: Robot, robot: Robot) -> Robot:
    """A prior that has the links and joints of a robot. Raises RobotError where it has others."""
    unlike = sorted(set(robot.parameters) - set(prior.parameters))
    bodies = [name for name in unlike if name.startswith("link")]
    if bodies or len(prior.joints) != len(robot.joints):
        what = bodies[0] if bodies else f"{len(robot.joints)} joints"
        raise RobotError(f"prior {prior.name} has no {what}; give a model of the same arm")
    return prior


def near(found: Identified, prior: Robot) -> Identified:
    """The same solution; what the data leave open of the written model stays near a prior of the same arm."""
    reduced, solution, joints = found.reduced, found.solution, len(found.robot.joints)
    p = consistent(found.robot, reduced, solution, prior)
    p, held = held_masses(
        found.robot, reduced, solution, prior, p, lambda p: relative_error(reduced, p, joints)["all"]
    )
    robot = found.robot.with_parameters(dict(zip(reduced.columns, p, strict=True)))
    found, notes = _hinges_of(replace(found, robot=robot), prior)
    notes += [held] if held else []
    kept = [name for name, text in found.support.items() if text == "no"]
    note = f"what the data leave open stays near {prior.name}"
    note += f"; they say nothing of {', '.join(kept)}" if kept else ""
    return replace(found, notes=(*found.notes, note, *notes, *_unlike(found, prior)))


def with_motors(found: Identified, inertias: Mapping[str, float], prior: Robot | None) -> Identified:
    """The same solution, its model written with motor inertias by name that something else than it tells.

    What it tells itself stays; and all does where no bodies that can exist go with them.
    """
    known = {name: J for name, J in inertias.items() if found.support.get(name) == "combination"}
    try:
        p = consistent(found.robot, found.reduced, found.solution, prior, known=known)
    except LogError:
        return found
    return replace(found, robot=found.robot.with_parameters(dict(zip(found.reduced.columns, p, strict=True))))


def soft_hinges(names: Sequence[str], solution: Solution, prior: Robot) -> dict[str, float]:
    """A prior's stiffness and damping of each hinge whose stiffness the solution does not tell from none."""
    known, std = prior.parameters, solution.std
    least = np.where(np.isfinite(std), CONFIDENCE * std, 0.0)
    soft = [n for n, v, few in zip(names, solution.p, least, strict=True) if ".k[" in n and v <= few]
    soft = [name for name in soft if known.get(name, 0.0) > 0]
    both = (*soft, *(name.replace(".k[", ".d[") for name in soft))
    return {name: known[name] for name in both if name in known}


def _hinges_of(found: Identified, prior: Robot) -> tuple[Identified, list[str]]:
    """With the prior's hinge where the data ask for one without stiffness, and a sentence about each.

    A hinge must have stiffness: what asks for none is noise in the measured deformation, or too little load.
    """
    values = soft_hinges(found.reduced.columns, found.solution, prior)
    notes = [
        f"{name} keeps the {stiffness:.6g} N m/rad of {prior.name}, and so does its damping: the logs do not "
        "tell its stiffness from none, which is noise in the deformation or too little load to tell"
        for name, stiffness in values.items()
        if ".k[" in name
    ]
    return replace(found, robot=found.robot.with_parameters(values)), notes


def disagreements(found: Identified) -> tuple[str, ...]:
    """A sentence about combinations in which no body that can exist near a prior does as the data ask.

    found   with intervals that hold: those of a mere regression would call its bias a disagreement
    """
    from scipy.stats import norm

    p, told = found.robot.parameters, [b for b in found.base if np.isfinite(b.std) and b.std > 0]
    limit = norm.isf(LEVEL / 2 / max(len(told), 1))  # one in all of them by chance in a twentieth of logs
    written = [sum(factor * p[name] for factor, name in b.terms) for b in told]
    far = [(abs(w - b.value) / b.std, w, b) for w, b in zip(written, told, strict=True)]
    worst = sorted((x for x in far if x[0] > limit), key=lambda x: -x[0])[:_WORST]
    if not worst:
        return ()
    named = "; ".join(
        f"{b.expression} is written as {w:.4g}, and they ask for {b.value:.4g}" for _, w, b in worst
    )
    cause = "an effect that is missing, a wrong sign or zero of a channel, or noise taken for motion"
    return (f"the written model and the logs disagree: {named}; {cause}",)


def impossible(found: Identified) -> tuple[str, ...]:
    """A sentence about sums of masses, inertias and frictions that come out below zero beyond chance.

    found   with intervals that hold
    """
    told = [b for b in found.base if np.isfinite(b.std) and b.std > 0 and _cannot_be_negative(b)]
    below = sorted((b for b in told if b.value < -_IMPOSSIBLE * b.std), key=lambda b: b.value / b.std)
    if not below:
        return ()
    named = "; ".join(f"{b.expression} = {b.value:.4g} ± {CONFIDENCE * b.std:.2g}" for b in below[:_WORST])
    cause = "a wrong sign, unit or zero of a channel, a wrong axis, or something large that is missing"
    return (f"no body and no friction is below zero, and the logs ask for {named}: {cause}",)


def _cannot_be_negative(b: BaseParameter) -> bool:
    return all(factor > 0 and name.endswith(_POSITIVE) for factor, name in b.terms)


def _unlike(found: Identified, prior: Robot) -> list[str]:
    """A sentence about masses that are not those of the prior."""
    written = found.robot.parameters
    far = unlike(written, prior)
    named = ", ".join(f"{n} ({written[n]:.3g} kg, there {m:.3g})" for n, m in far.items())
    return [f"more than a factor of {ALIKE:g} from {prior.name}: {named}"] if far else []


def without_intervals(found: Identified) -> Identified:
    """The same values of which nothing is said about how far they may be off."""
    solution = replace(found.solution, covariance=np.full_like(found.solution.covariance, np.nan))
    base = [replace(parameter, std=float("nan")) for parameter in found.base]
    return replace(found, solution=solution, base=base)


def relative_error(reduced: Reduced, p: np.ndarray, joints: int) -> dict[str, float]:
    """100 |y - A p| / |y| of the first `joints` equations, each and all [%]; nan without torque in use."""
    squares = residual_squares(reduced, p)[:joints]
    signal = reduced.signal_squares[:joints]

    def percent(square: float, of: float) -> float:
        return float(100 * np.sqrt(square / of)) if of > 0 else float("nan")

    each = {joint_name(k + 1): percent(squares[k], signal[k]) for k in range(joints)}
    return each | {"all": percent(squares.sum(), signal.sum())}


def told_errors(errors: Mapping[str, float]) -> dict[str, float | None]:
    """`relative_error` for JSON, which knows no nan."""
    return {joint: finite(error) for joint, error in errors.items()}


def finite(value: float) -> float | None:
    """A number as JSON has it: none where it is not finite."""
    return float(value) if np.isfinite(value) else None
