"""What of an MJCF is no body: actuators, equalities, and what a robot here has no place for."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from flexmodels.robot import RobotError
from flexmodels.settings.controller import Controller

_JOINT_EQUALITY = 2  # mjEQ_JOINT
_ON_JOINT = 0  # mjTRN_JOINT
_FIXED, _NONE, _AFFINE = 0, 0, 1  # gain and bias types of motors and servos


def couplings_of(model: Any) -> dict[int, tuple[int, float]]:
    """Following joint -> its leader and the factor, of the active linear equalities between two joints.

    Raises RobotError.
    """
    ties: dict[int, tuple[int, float]] = {}
    for i in range(model.neq):
        if model.eq_type[i] != _JOINT_EQUALITY or not model.eq_active0[i]:
            continue
        follower, leader = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        name = model.joint(follower).name
        if leader < 0:
            raise RobotError(f"joint {name} is held by an equality; make its body fixed")
        constant, factor, *higher = model.eq_data[i][:5]
        at, leading = model.jnt_qposadr[follower], model.jnt_qposadr[leader]
        constant += model.qpos0[at] - factor * model.qpos0[leading]
        if any(higher) or abs(constant) > 1e-12:
            raise RobotError(f"joint {name} follows another by an offset or a curve; only a factor is read")
        ties[follower] = (leader, float(factor))
    for follower, (leader, factor) in ties.items():
        if leader in ties:
            first, more = ties[leader]
            ties[follower] = (first, factor * more)
    return ties


def controller_of(model: Any, driven: list[int]) -> Controller | None:
    """Position servos as a digital PD at MuJoCo's time step; None unless every driven joint has one."""
    gains = {j: gain for j, gain in _servos(model)}
    if any(j not in gains for j in driven):
        return None
    Kp, Kd = zip(*(gains[j] for j in driven), strict=True)
    return Controller(1.0 / float(model.opt.timestep), Kp, Kd, (0.0,) * len(driven))


def _servos(model: Any) -> Iterator[tuple[int, tuple[float, float]]]:
    """(joint, (Kp, Kd)) of position actuators, per unit of the joint."""
    for a in range(model.nu):
        kp, (_, proportional, derivative) = model.actuator_gainprm[a][0], model.actuator_biasprm[a][:3]
        simple = model.actuator_gaintype[a] == _FIXED and model.actuator_biastype[a] == _AFFINE
        if model.actuator_trntype[a] == _ON_JOINT and simple and np.isclose(kp, -proportional):
            gear = float(model.actuator_gear[a][0])
            yield int(model.actuator_trnid[a][0]), (float(kp) * gear**2, -float(derivative) * gear**2)


def left_out(model: Any) -> tuple[str, ...]:
    """A sentence each."""
    notes = []
    if any(model.jnt_type[j] == 0 for j in range(model.njnt)):
        notes.append("the free joint of the root is taken out: the robot stands on a fixed base")
    plain = {_NONE, _AFFINE}
    odd = [
        model.actuator(a).name or f"number {a + 1}"
        for a in range(model.nu)
        if model.actuator_trntype[a] != _ON_JOINT
        or model.actuator_gaintype[a] != _FIXED
        or model.actuator_biastype[a] not in plain
    ]
    if odd:
        notes.append(f"actuators {', '.join(odd)} are neither motors nor position servos at a joint")
    lagging = [
        model.actuator(a).name or f"number {a + 1}" for a in range(model.nu) if model.actuator_dyntype[a]
    ]
    if lagging:
        notes.append(
            f"the dynamics (dyntype) of actuators {', '.join(lagging)} are left out: they act at once"
        )
    notes += _partly_driven(model)
    notes += _surroundings(model)
    if model.ntendon:
        notes.append(f"{model.ntendon} tendons are left out")
    if sum(model.eq_type[i] != _JOINT_EQUALITY for i in range(model.neq)):
        notes.append("equalities that do not tie two joints are left out")
    if any(model.dof_frictionloss > 0):
        notes.append(
            "MuJoCo softens frictionloss (solref, solimp: a stuck joint creeps); here a joint sticks exactly"
        )
    if controller_of(model, _driven(model)) is not None:
        notes.append(
            "position servos act at every step of MuJoCo; here a digital PD at its rate, whose derivative "
            "is that of the error"
        )
    return tuple(notes)


def _partly_driven(model: Any) -> Iterator[str]:
    """That servos at some joints only are no controller."""
    served, driven = {j for j, _ in _servos(model)}, _driven(model)
    bare = [model.joint(j).name for j in driven if j not in served]
    if served and bare:
        yield (
            f"the gains of the position servos are left out, as {', '.join(bare)} has none: a controller "
            "drives every joint; give the robot file a [controller] or a [servo]"
        )


def _surroundings(model: Any) -> Iterator[str]:
    """Forces that no joint and no inertia makes."""
    lifted = [model.body(b).name for b in range(model.nbody) if model.body_gravcomp[b]]
    if lifted:
        yield f"gravcomp of {', '.join(lifted)} is left out: the weight acts on the joints here"
    if model.opt.density or model.opt.viscosity:
        yield "the forces of the fluid (option density, viscosity) are left out"


def _driven(model: Any) -> list[int]:
    ties = couplings_of(model)
    return [j for j in range(model.njnt) if model.jnt_type[j] in (2, 3) and j not in ties]
