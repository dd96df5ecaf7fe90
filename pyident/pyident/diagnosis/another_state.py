"""Held-out logs that the parameters of the fitted logs do not follow.

What a law takes of held-out logs says nothing of what is left of them once nothing is named: friction of a
cold morning, a drive that was exchanged, or an effect that the fitted logs' parameters make up for along
their own motions. So each of them is asked what it leaves with the parameters of the fitted logs, and with
parameters of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmodels.coordinate import joint_name
from flexmodels.joint import parameter_name
from pyident.diagnosis.base.candidates import Candidate, columns, units_of
from pyident.diagnosis.base.residual_over_floor import bands_of
from pyident.diagnosis.base.setting import Setting
from pyident.diagnosis.base.standing_out import bands_in_doubt, in_bands
from pyident.diagnosis.search.held_out import HeldOut
from pyident.diagnosis.search.search import Search
from pyident.estimation.identify import relative_error
from pyident.logs.log import Log
from pyident.regression.equations import Problem
from pyident.regression.spectrum import Equations
from pyident.simulation.denoised import denoised

_FAR = 2.0  # times the rms of the floor
_SURE = 4.0  # times what the parameters' own noise leaves on average: seldom more
_MOSTLY = 0.95  # of what is left so, that one thing which differs takes
_LITTLE = 0.1  # of what another friction takes: a part of it that is not worth a word
_HALF = 0.5  # of what all logs together leave, that each by itself does at most
_FRICTION = ("coulomb", "viscous", "offset")


@dataclass(frozen=True)
class AnotherState:
    """A held-out log, one joint's equation of it, and the rms there over the floor's.

    carried   with the fitted logs' parameters;  own: with its own
    differs   what of the joint makes most of the difference, in words, and by how much; None: nothing alone
    doubted   whether slow noise of its torque may make the difference
    """

    log: str
    joint: int
    carried: float
    own: float
    differs: tuple[str, str] | None
    doubted: bool = False

    @property
    def note(self) -> str:
        why = (
            "the robot was in another state (a load, a gain, a zero), or lacks something that the parameters "
            "of the fitted logs make up for; fit it together with those"
        )
        if self.differs is not None:
            why = f"{self.differs[0]} differs there, {self.differs[1]}"
        if self.doubted:
            why = f"{why}; or its torque has slow noise, which these logs do not show that far down"
        return (
            f"{self.log} leaves {self.carried:.2g} times its floor at {joint_name(self.joint)} with the "
            f"parameters of the fitted logs, {self.own:.2g} times with its own: {why}"
        )


def fitted_apart(setting: Setting) -> str:
    """That logs which no model fits together are fitted well each by itself, in a sentence; empty: no."""
    if len(setting.logs) < 2:
        return ""
    robot, joints = setting.robot, len(setting.robot.joints)

    def left(log: Log) -> float:
        """Per cent of its torques that a regression of its own leaves."""
        found = setting.estimator(Problem(robot, (denoised(robot, log),)))
        return relative_error(found.reduced, found.solution.p, joints)["all"]

    together = relative_error(setting.reduced, setting.solution.p, joints)["all"]
    each = max(left(log) for log in setting.logs)
    if each > _HALF * together:
        return ""
    return (
        " The logs are of different states, such as a load in one of them: each by itself leaves at most "
        f"{each:.2g} % of its torques, all together {together:.2g} %; diagnose them one by one, or let "
        "`pyident payload` tell the load."
    )


def other_states(beside: Search, held: HeldOut, heldout: Sequence[Log]) -> list[AnotherState]:
    """Of all held-out logs and joints. beside: rests on what was named; heldout: the logs of `held`."""
    if not held.equations:
        return []
    carried, own = (held.residuals(beside, anew) for anew in (False, True))
    return [
        state
        for number, log in enumerate(heldout)
        for joint, _ in beside.robot.numbered
        if (state := _state(beside, held, log, number, joint, carried, own)) is not None
    ]


def _state(
    beside: Search,
    held: HeldOut,
    log: Log,
    number: int,
    joint: int,
    carried: Sequence[np.ndarray],
    own: Sequence[np.ndarray],
) -> AnotherState | None:
    """Of one joint in one log, by number; None where the log follows there, by any parameters or none."""
    ex, row, equations = beside.examination, joint - 1, held.equations[number]
    bands = bands_of([equations])
    floor = max(ex.excess([carried[number]], bands, [row])[1], 1e-300)
    far, near = (float(np.square(left[number][row]).sum()) for left in (carried, own))
    told_by = np.square(equations.A[row] @ ex.base.directions).sum()  # parameters of white noise
    by_chance = float(told_by) * max(float(beside.over_floor[row]), 1.0)
    if far - near < _FAR**2 * (floor + _SURE * by_chance):
        return None
    here_too = bool(bands_in_doubt(ex, beside.base)[row].any())  # then it bends the parameters as well
    doubted = here_too or far - near < _FAR**2 * (
        _floor_with_slow_noise(beside, bands, row) + _SURE * by_chance
    )
    differs = _differs(beside, equations, joint, carried[number][row])
    fitted = {part.source for part in ex.setting.logs}
    name = f"the held-out part of {log.source}" if log.source in fitted else log.source
    by_fitted, by_own = float(np.sqrt(far / floor)), float(np.sqrt(near / floor))
    return AnotherState(name, joint, by_fitted, by_own, differs, doubted)


def _floor_with_slow_noise(beside: Search, bands: Sequence[np.ndarray], row: int) -> float:
    """Energy of an equation's floor, where noise rises below the frequencies at which it was measured."""
    ex = beside.examination
    count = sum(inside.sum(axis=0) for inside in bands) * (ex.count > 0)
    return float((ex.replica_energy.mean(axis=0) * count * in_bands(ex, beside.base).rise)[row].sum())


def _differs(beside: Search, log: Equations, joint: int, left: np.ndarray) -> tuple[str, str] | None:
    """What of a joint takes most of what is left (E,) of its torque: its zero, its gain, or its friction."""
    level, names = [beside.examination.floor.at(log.band)], beside.robot.joints[joint - 1].values
    listed = [Candidate(name, joint) for name in _FRICTION]
    each = {
        c.effect: columns(beside.robot, c, [log], level)[0][joint - 1] for c in listed if c.effect in names
    }
    zero = each.get("offset")
    if zero is not None and (x := _taking(zero, left)) is not None:
        return "the zero of its torque", f"by {x[0]:+.2g} {_unit(beside, joint, 'offset')}"
    if (x := _taking((log.y[joint - 1] - left)[:, None], left)) is not None:
        return "the gain of its torque", f"{1 + x[0]:.3g} times that of the others"
    if each and (x := _taking(np.hstack(list(each.values())), left)) is not None:
        size = [abs(value) * np.linalg.norm(X) for value, X in zip(x, each.values(), strict=True)]
        pairs = [(n, v) for n, v, s in zip(each, x, size, strict=True) if s > _LITTLE * max(size)]
        said = (f"{parameter_name(joint, n, n)} by {v:+.2g} {_unit(beside, joint, n)}" for n, v in pairs)
        return "its friction", ", ".join(said)
    return None


def _taking(X: np.ndarray, left: np.ndarray) -> np.ndarray | None:
    """(K,) coefficients of columns (E, K) that take most of what is left (E,); None where they do not."""
    change = np.linalg.lstsq(X, left, rcond=None)[0]
    return change if np.square(left - X @ change).sum() <= (1 - _MOSTLY) * np.square(left).sum() else None


def _unit(beside: Search, joint: int, effect: str) -> str:
    return next(iter(units_of(beside.robot, Candidate(effect, joint)).values()))


def sentence(states: Sequence[AnotherState]) -> str:
    """What a diagnosis adds to its verdict; empty: nothing."""
    logs = dict.fromkeys(state.log for state in states)
    worst = [max((s for s in states if s.log == log), key=lambda s: s.carried) for log in logs]
    return "".join(f" But {_told(state)}." for state in worst)


def _told(state: AnotherState) -> str:
    why = f", where {state.differs[0]} differs" if state.differs else ": it does not follow from these logs"
    why += ", or has slow noise" if state.doubted else ""
    return f"{state.log} leaves {state.carried:.2g} times its floor at {joint_name(state.joint)}{why}"
