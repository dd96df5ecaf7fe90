"""Candidates for the axis's friction, and their fit in free run from the voltage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.logs.log import Log
from pyident.simulation.free_run import FreeRun, Plant, free_run_of

Part = tuple[int, int]  # samples from and to

_BASE = {"link1.m": 5.0, "joint1.viscous": 20.0, "joint1.coulomb": 1.0, "joint1.offset": 0.3}
_ROUNDS = 40
_SETTLED = 1e-5  # relative change of the error or of the parameters at which a fit ends
# What grows in the course of a log, and the parameter that it adds to.
_WARMED = {
    "joint1.directional_drift.drift": "joint1.asymmetric_coulomb.viscous",
    "joint1.viscous_drift.drift": "joint1.viscous",
}
_LIGHTEST = 1.0  # kg
_WRONG = 1e3  # mm, where a simulation fails


@dataclass(frozen=True)
class Structure:
    """name in words;  laws: effects at the joint;  free: further free parameter -> its typical change;
    start: values of those that must not set out from zero."""

    name: str
    laws: tuple[str, ...] = ()
    free: Mapping[str, float] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)

    @property
    def scale(self) -> dict[str, float]:
        """Free parameter -> typical change."""
        return _BASE | dict(self.free)

    def of(self, robot: Robot) -> Robot:
        """The robot with the structure's laws at their start."""
        for law in self.laws:
            robot = robot.with_effect(1, law)
        return robot.with_parameters(dict(self.start))


_DIRECTION = {"joint1.asymmetric_coulomb.viscous": 10.0}
_DRIFT = {"joint1.directional_drift.drift": 0.2}
_DIRECTED = ("asymmetric_coulomb", "directional_drift")
_STRIBECK = {"joint1.stribeck.level": 1.0, "joint1.stribeck.velocity": 0.02}
_SPRING = {"joint1.joint_spring.stiffness": 2.0}
_LOAD = {"joint1.load_dependent_friction.coefficient": 0.02}

STRUCTURES = (
    Structure("symmetric"),
    Structure("symmetric, Stribeck", ("stribeck",), _STRIBECK, {"joint1.stribeck.velocity": 0.03}),
    Structure("symmetric, spring", ("joint_spring",), _SPRING),
    Structure("symmetric, load", ("load_dependent_friction",), _LOAD),
    Structure("symmetric, warming", ("viscous_drift",), {"joint1.viscous_drift.drift": 0.2}),
    Structure("directional", ("asymmetric_coulomb",), _DIRECTION),
    Structure("directional, spring", ("asymmetric_coulomb", "joint_spring"), _DIRECTION | _SPRING),
    Structure("directional, load", ("asymmetric_coulomb", "load_dependent_friction"), _DIRECTION | _LOAD),
    Structure("directional, warming", _DIRECTED, _DIRECTION | _DRIFT),
    Structure("directional, warming, spring", (*_DIRECTED, "joint_spring"), _DIRECTION | _DRIFT | _SPRING),
    Structure(
        "directional, warming, load", (*_DIRECTED, "load_dependent_friction"), _DIRECTION | _DRIFT | _LOAD
    ),
    Structure(
        "directional, warming, quadratic",
        (*_DIRECTED, "nonlinear_viscous"),
        _DIRECTION | _DRIFT | {"joint1.nonlinear_viscous.coefficient": 50.0},
    ),
)  # fmt: skip


def parts_of(robot: Robot, log: Log, parts: Sequence[Part]) -> list[FreeRun]:
    """Free runs over parts of a log, each from its own window."""
    return [free_run_of(robot, log, part=part) for part in parts if part[1] > part[0]]


def fit(structure: Structure, robot: Robot, runs: Sequence[FreeRun], plant: Plant) -> dict[str, float]:
    """The free parameters, from the robot's own on, whose free runs come nearest to the positions."""
    names, scale = list(structure.scale), np.array(list(structure.scale.values()))
    fixed = {n: v for n, v in robot.parameters.items() if n not in names}
    lower = np.array([_lower(robot).get(n, -np.inf) for n in names]) / scale

    def residuals(points: np.ndarray) -> np.ndarray:
        """(points, samples) [mm]"""
        sets = [fixed | dict(zip(names, (p * scale).tolist(), strict=True)) for p in points]
        each = [run.missed(plant, [_at(run, values) for values in sets]) for run in runs]
        missed = [np.concatenate(m) for m in zip(*each, strict=True)]
        return np.clip(np.nan_to_num(1e3 * np.array(missed)[:, :, 0], nan=_WRONG), -_WRONG, _WRONG)

    best = np.array([robot.parameters[n] for n in names]) / scale
    for step in (1e-2, 1e-3):  # sticking makes the error rough in small steps

        def slopes(p: np.ndarray, step: float = step) -> np.ndarray:
            up, down = p + step * np.eye(len(p)), np.maximum(p - step * np.eye(len(p)), lower)
            moved = residuals(np.concatenate([up, down]))
            return (moved[: len(p)] - moved[len(p) :]).T / np.diag(up - down)

        found = least_squares(
            lambda p: residuals(p[None])[0],
            np.maximum(best, lower + 2 * step),
            jac=slopes,  # pyright: ignore[reportArgumentType]
            bounds=(lower, np.inf),
            x_scale="jac",
            max_nfev=_ROUNDS,
            ftol=_SETTLED,
            xtol=_SETTLED,
        )
        best = found.x
    return dict(zip(names, (best * scale).tolist(), strict=True))


def _at(run: FreeRun, values: Mapping[str, float]) -> dict[str, float]:
    """Values as a simulation needs them whose clock starts with the run and not with the log."""
    since = float(run.plan.time[0])
    moved = {
        level: values[level] + since * values[drift] for drift, level in _WARMED.items() if drift in values
    }
    return {**values, **moved}


def _lower(robot: Robot) -> dict[str, float]:
    """Parameter -> least value, of laws and mass."""
    bounds = {"link1.m": _LIGHTEST}
    for k, joint in robot.numbered:
        for law in joint.values:
            bounds |= {parameter_name(k, law, p.name): p.lower for p in joint.catalogue[law].parameters}
    return bounds


def rms(robot: Robot, values: Mapping[str, float], runs: Sequence[FreeRun], plant: Plant) -> float:
    """Free-run error [mm] over all runs."""
    missed = [run.missed(plant, [_at(run, robot.parameters | dict(values))])[0] for run in runs]
    return float(1e3 * np.sqrt(np.mean(np.concatenate(missed) ** 2)))
